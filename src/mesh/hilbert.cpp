// Hilbert curve keys by a table of the curve's states.
#include "mesh/hilbert.hpp"

#include <algorithm>
#include <array>

namespace skein {
namespace {

constexpr int kBits = 21;

std::uint32_t cell(double x, double low, double high) noexcept {
  if (!(high > low)) return 0;
  const double s = (x - low) / (high - low) * static_cast<double>(1u << kBits);
  return static_cast<std::uint32_t>(std::clamp(s, 0.0, static_cast<double>((1u << kBits) - 1)));
}

/// Spreads the low 21 bits so that two zero bits follow each.
std::uint64_t spread(std::uint64_t v) noexcept {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffULL;
  v = (v | v << 16) & 0x1f0000ff0000ffULL;
  v = (v | v << 8) & 0x100f00f00f00f00fULL;
  v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
  v = (v | v << 2) & 0x1249249249249249ULL;
  return v;
}

constexpr unsigned rotated_left(unsigned v, unsigned by) noexcept { return (v << by | v >> (3 - by)) & 7; }
constexpr unsigned gray(unsigned v) noexcept { return v ^ v >> 1; }

/// One level of the curve: in which of the eight cells (x, y, z bits) of a cube it is at which step, and how it goes on
/// in there. A state is the corner where the curve enters (3 bits) and the axis along which it leaves.
struct Step {
  unsigned state, at;
};
constexpr Step step_of(unsigned state, unsigned cell) noexcept {
  const unsigned entry = state & 7, axis = state >> 3, turn = (axis + 1) % 3;
  const unsigned turned = rotated_left(cell ^ entry, (3 - turn) % 3);
  unsigned at = 0;
  while (gray(at) != turned) ++at;
  // Where the curve enters the cell that it visits as number `at`, and along which axis it leaves.
  const unsigned corner = at == 0 ? 0 : gray(2 * ((at - 1) / 2));
  const unsigned odd = at % 2 == 1 ? at : at - 1;
  unsigned ones = 0;
  if (at != 0) {
    for (unsigned k = odd; (k & 1) != 0; k >>= 1) ++ones;
  }
  return {(entry ^ rotated_left(corner, turn)) | ((axis + ones + 1) % 3) << 3, at};
}

/// Two levels at once: state, six bits of cells -> next state and six bits of the key.
constexpr auto kTwoLevels = [] {
  std::array<std::array<std::uint16_t, 64>, 24> table{};
  for (unsigned state = 0; state < 24; ++state) {
    for (unsigned cells = 0; cells < 64; ++cells) {
      const Step a = step_of(state, cells >> 3), b = step_of(a.state, cells & 7);
      table[state][cells] = static_cast<std::uint16_t>(b.state << 6 | a.at << 3 | b.at);
    }
  }
  return table;
}();

}  // namespace

std::uint64_t hilbert_key(Vec3 x, const Box& box) noexcept {
  // 21 levels are ten pairs and one more, for which a level of zeros is appended and then cut off.
  const std::uint64_t cells = spread(cell(x.x, box.low.x, box.high.x)) << 2 |
                              spread(cell(x.y, box.low.y, box.high.y)) << 1 | spread(cell(x.z, box.low.z, box.high.z));
  std::uint64_t key = 0;
  unsigned state = 0;
  for (int level = kBits - 2; level >= -1; level -= 2) {
    const std::uint64_t pair = level >= 0 ? cells >> (3 * level) : cells << 3;
    const unsigned next = kTwoLevels[state][pair & 63];
    key = key << 6 | (next & 63);
    state = next >> 6;
  }
  return key >> 3;
}

}  // namespace skein
