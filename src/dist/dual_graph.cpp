// The dual graph of a distributed mesh.
#include "dist/dual_graph.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "dist/interface_faces.hpp"
#include "partition/graph_rows.hpp"

namespace skein {

namespace {

/// A face to another rank, and what stands behind it.
struct BorderFace {
  FaceId face;
  RemoteNode behind;
  std::int32_t weight;  ///< the larger one of its two sides
};

std::int32_t weight_of(std::span<const std::int32_t> face_weight, FaceId f) noexcept {
  return face_weight.empty() ? 1 : std::max(1, face_weight[idx(f)]);
}

/// Makes the rows of the graph, of some tetrahedra at a time.
class RowMaker {
 public:
  RowMaker(const TetMesh& m, std::span<const std::int32_t> face_weight, const std::vector<BorderFace>& border,
           const std::vector<RemoteNode>& remote)
      : m_(m), face_weight_(face_weight), border_(border), remote_(remote) {}

  void operator()(std::size_t begin, std::size_t end, std::vector<Edge>& edge, std::span<std::uint32_t> ends) const {
    auto next = std::lower_bound(border_.begin(), border_.end(), make_face(to_id<TetId>(begin), 0),
                                 [](const BorderFace& b, FaceId f) { return b.face < f; });
    for (const TetId t : IdRange<TetId>(begin, end)) {
      const std::size_t row = edge.size();
      for (std::size_t s = 0; s < 4; ++s) {
        const FaceId f = make_face(t, s), o = m_.tet2face[t][s];
        if (o != kNoFace) {
          add(edge, row, NodeId{num(face_tet(o))}, std::max(weight_at(f), weight_at(o)));
        } else if (next != border_.end() && next->face == f) {
          const auto at = std::lower_bound(remote_.begin(), remote_.end(), next->behind) - remote_.begin();
          add(edge, row, to_id<NodeId>(m_.tet_slots() + static_cast<std::size_t>(at)), next->weight);
          ++next;
        }
      }
      ends[idx(t) - begin] = static_cast<std::uint32_t>(edge.size());
    }
  }

 private:
  [[nodiscard]] std::int32_t weight_at(FaceId f) const noexcept { return weight_of(face_weight_, f); }

  /// Two tetrahedra may share two faces.
  static void add(std::vector<Edge>& edge, std::size_t row, NodeId to, std::int32_t weight) {
    for (std::size_t e = row; e < edge.size(); ++e) {
      if (edge[e].to == to) return void(edge[e].weight += weight);
    }
    edge.push_back({to, weight});
  }

  const TetMesh& m_;
  std::span<const std::int32_t> face_weight_;
  const std::vector<BorderFace>& border_;
  const std::vector<RemoteNode>& remote_;
};

/// Collective. `border` ascending by face.
DistGraph graph_of(const Comm& comm, const TetMesh& m, const std::vector<BorderFace>& border,
                   std::span<const double> work, std::span<const std::int32_t> face_weight, int threads) {
  const std::size_t n = m.tet_slots();
  std::vector<std::pair<NodeId, RemoteNode>> links(border.size());
  for (std::size_t i = 0; i < border.size(); ++i) links[i] = {NodeId{num(face_tet(border[i].face))}, border[i].behind};
  DistGraph out;
  out.ghosts = make_ghosts(links);
  set_weights(comm, work, out.graph);
  make_rows(out.graph, n, 4 * n, threads_for(n, threads), RowMaker(m, face_weight, border, out.ghosts.remote));
  return out;
}

}  // namespace

DistGraph dual_graph(const Comm& comm, const DistMesh& dist, std::span<const double> work,
                     std::span<const std::int32_t> face_weight, int threads) {
  const auto faces = match_interface(comm, dist);
  std::vector<std::int32_t> mine(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) mine[i] = weight_of(face_weight, faces[i].mine);
  const auto theirs = swap_over_interface(comm, faces, mine);
  std::vector<BorderFace> border(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const RemoteNode behind{faces[i].rank, NodeId{num(face_tet(faces[i].theirs))}};
    border[i] = {faces[i].mine, behind, std::max(mine[i], theirs[i])};
  }
  return graph_of(comm, dist.mesh, border, work, face_weight, threads);
}

DistGraph dual_graph(const TetMesh& mesh, std::span<const double> work, std::span<const std::int32_t> face_weight,
                     int threads) {
  return graph_of(Comm::self(), mesh, {}, work, face_weight, threads);
}

}  // namespace skein
