// Filling the rows of a graph by several threads.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "partition/graph.hpp"

namespace skein {

/// Fills g.first and g.edge with n rows. append(begin, end, edge, ends) appends the rows [begin, end) to `edge`, and
/// the value of edge.size() after each row to `ends`. Every thread makes consecutive rows; then they are joined.
template <class Append>
void make_rows(Graph& g, std::size_t n, std::size_t expected_edges, int threads, const Append& append) {
  g.first.resize(n + 1);
  g.first[0] = 0;
  const std::span<std::uint32_t> ends(g.first.data() + 1, n);
  if (threads == 1) {
    g.edge.reserve(expected_edges);
    append(0, n, g.edge, ends);
    return;
  }
  std::vector<std::vector<Edge>> piece(static_cast<std::size_t>(threads));
  const auto share = [&](int w) { return std::pair(share_begin(n, w, threads), share_begin(n, w + 1, threads)); };
  in_parallel(threads, [&](int w) {
    const auto [begin, end] = share(w);
    auto& mine = piece[w];
    mine.reserve(expected_edges / static_cast<std::size_t>(threads));
    append(begin, end, mine, ends.subspan(begin, end - begin));
  });
  std::vector<std::size_t> start(piece.size() + 1, 0);
  for (std::size_t w = 0; w < piece.size(); ++w) start[w + 1] = start[w] + piece[w].size();
  grow_in_parallel(g.edge, start.back(), threads);
  in_parallel(threads, [&](int w) {
    const auto [begin, end] = share(w);
    auto& mine = piece[w];
    const std::size_t at = start[w];
    std::copy(mine.begin(), mine.end(), g.edge.begin() + static_cast<std::ptrdiff_t>(at));
    mine = {};
    for (auto& e : ends.subspan(begin, end - begin)) e += static_cast<std::uint32_t>(at);
  });
}

}  // namespace skein
