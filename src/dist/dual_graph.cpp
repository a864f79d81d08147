// The dual graph of a distributed mesh.
#include "dist/dual_graph.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "dist/interface_faces.hpp"
#include "partition/graph_rows.hpp"

namespace skein {

DistGraph dual_graph(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                     std::span<const std::int32_t> face_weight, int threads) {
  const TetMesh& m = dist.mesh;
  const std::size_t n = m.tet_slots();
  const auto faces = match_interface(comm, dist);
  const auto weight_at = [&](FaceId f) { return face_weight.empty() ? 1 : std::max(1, face_weight[idx(f)]); };
  std::vector<std::int32_t> mine(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) mine[i] = weight_at(faces[i].mine);
  const auto theirs = swap_over_interface(comm, faces, mine);

  DistGraph out;
  std::vector<std::pair<NodeId, RemoteNode>> links(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    links[i] = {NodeId{num(face_tet(faces[i].mine))}, {faces[i].rank, NodeId{num(face_tet(faces[i].theirs))}}};
  }
  out.ghosts = make_ghosts(links);
  Graph& g = out.graph;
  set_weights(comm, work, g);
  const auto& remote = out.ghosts.remote;
  make_rows(g, n, 4 * n, threads_for(n, threads),
            [&](std::size_t begin, std::size_t end, std::vector<Edge>& edge, std::span<std::uint32_t> ends) {
              auto next = std::lower_bound(faces.begin(), faces.end(), make_face(to_id<TetId>(begin), 0),
                                           [](const InterfaceFace& i, FaceId f) { return i.mine < f; });
              for (const TetId t : IdRange<TetId>(begin, end)) {
                const std::size_t row = edge.size();
                const auto add = [&](NodeId to, std::int32_t w) {  // two tetrahedra may share two faces
                  for (std::size_t e = row; e < edge.size(); ++e) {
                    if (edge[e].to == to) return void(edge[e].weight += w);
                  }
                  edge.push_back({to, w});
                };
                for (std::size_t s = 0; s < 4; ++s) {
                  const FaceId f = make_face(t, s), o = m.tet2face[t][s];
                  if (o != kNoFace) {
                    add(NodeId{num(face_tet(o))}, std::max(weight_at(f), weight_at(o)));
                  } else if (next != faces.end() && next->mine == f) {
                    const auto i = static_cast<std::size_t>(next - faces.begin());
                    const auto at = std::lower_bound(remote.begin(), remote.end(), links[i].second) - remote.begin();
                    add(to_id<NodeId>(n + static_cast<std::size_t>(at)), std::max(mine[i], theirs[i]));
                    ++next;
                  }
                }
                ends[idx(t) - begin] = static_cast<std::uint32_t>(edge.size());
              }
            });
  return out;
}

}  // namespace skein
