// Meshes for the tests of mesh and kernel, and what no operator may change in them.
#pragma once
#include <map>
#include <random>
#include <string>
#include <vector>

#include "mesh/tet_mesh.hpp"

namespace skein::test {

enum class Shape {
  kBox,       ///< the unit cube
  kSkewed,    ///< a parallelepiped whose sides are flat to rounding only
  kCylinder,  ///< a sector between two cylinders, made of facets
  kSphere     ///< a piece between two spheres, made of facets
};

/// n^3 cells cut into six tetrahedra each. Six sides with references 11..16; feature edges along the three axes have
/// references 1, 2, 3.
struct MeshSpec {
  int n = 4;  ///< even for two regions
  Shape shape = Shape::kBox;
  bool two_regions = false;  ///< references 1 and 2, with a tagged interface (reference 17) between
  bool required = false;     ///< some triangles and vertices are required
  double perturb = 0;        ///< of inner vertices, relative to the cell
  unsigned seed = 1;
};

/// A valid mesh with adjacency, tags, feature edges, corners; all vertices are kActive.
TetMesh make_mesh(const MeshSpec& spec);
[[nodiscard]] constexpr bool is_flat_sided(Shape s) noexcept { return s == Shape::kBox || s == Shape::kSkewed; }

/// Feature edges from the tagged faces (not two faces at the edge, patches differ, or more than 45 degrees), corners
/// where they end, branch or bend.
void find_features(TetMesh& mesh);

/// The tetrahedra with label b as a mesh of their own; what they share with others is frozen. gid: number in `whole`.
TetMesh cut_out(const TetMesh& whole, const IdVector<TetId, int>& label, int b, IdVector<VertId, GlobalId>& gid);

/// What operators keep. Lengths, areas and volumes are sums over all live entities.
struct Measures {
  double volume = 0;
  std::map<int, double> volume_of;   ///< by tetrahedron reference
  std::map<int, double> area_of;     ///< by patch number
  std::map<int, double> feature_of;  ///< length by reference
  std::vector<Vec3> fixed;           ///< corners and required vertices, sorted by coordinates
};
Measures measure(const TetMesh& mesh);
/// Empty when both are equal up to a relative error; otherwise what differs. `surface`: areas and volumes count.
std::string differ(const Measures& a, const Measures& b, double tolerance, bool surface = true);

/// The faces that have no neighbour and are not on the hull, by their sorted vertices, sorted.
std::vector<std::array<VertId, 3>> interface_faces(const TetMesh& mesh);

}  // namespace skein::test
