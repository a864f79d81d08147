// Matching of interface faces by a rendezvous on their global ids.
#include "dist/interface_faces.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"

namespace skein {
namespace {

struct FaceCopy {
  std::array<GlobalId, 3> gid;
  Rank rank;
  FaceId face;
  std::int32_t odd;
};

}  // namespace

std::vector<InterfaceFace> match_interface(const Comm& comm, const DistMesh& dist) {
  const TetMesh& m = dist.mesh;
  std::vector<FaceCopy> copies;
  std::vector<Rank> dest;
  for (const TetId t : IdRange<TetId>(m.tet_slots())) {
    for (std::size_t f = 0; f < 4; ++f) {
      if (m.tet2face[t][f] != kNoFace || is_hull(m.face_tag[t][f])) continue;
      const FaceId face = make_face(t, f);
      const FaceKey key = face_key(m, dist.vert2gid, face);
      copies.push_back({key.gid, comm.rank(), face, key.odd ? 1 : 0});
      dest.push_back(meeting_rank(key.gid, comm.size()));
    }
  }
  const Inquiry<FaceCopy> inquiry(comm, dest, copies);
  const auto& asked = inquiry.asked().items;
  std::vector<std::uint32_t> order(asked.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t i, std::uint32_t j) { return std::pair(asked[i].gid, i) < std::pair(asked[j].gid, j); });
  struct Partner {
    Rank rank;
    FaceId face;
  };
  std::vector<Partner> partner(asked.size());
  std::string fault;
  for (std::size_t i = 0; i < order.size();) {
    std::size_t j = i + 1;
    while (j < order.size() && asked[order[j]].gid == asked[order[i]].gid) ++j;
    const FaceCopy& a = asked[order[i]];
    if (j - i == 2 && a.odd != asked[order[i + 1]].odd) {
      const FaceCopy& b = asked[order[i + 1]];
      partner[order[i]] = {b.rank, b.face};
      partner[order[i + 1]] = {a.rank, a.face};
    } else if (fault.empty()) {
      fault = fmt::format("interface face {} {} {} (global ids) has {} copies{}", num(a.gid[0]), num(a.gid[1]),
                          num(a.gid[2]), j - i, j - i == 2 ? " on the same side" : ", not two");
    }
    i = j;
  }
  agree(comm, [&] {
    if (!fault.empty()) throw Error(ExitCode::kInternal, fault);
  });
  const auto answer = inquiry.answer(partner);
  std::vector<InterfaceFace> faces(copies.size());
  for (std::size_t i = 0; i < faces.size(); ++i) faces[i] = {copies[i].face, answer[i].rank, answer[i].face};
  return faces;
}

}  // namespace skein
