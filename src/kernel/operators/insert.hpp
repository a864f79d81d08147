// Insertion of points as Delaunay cavities in the metric.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "kernel/cavity.hpp"
#include "kernel/cone.hpp"
#include "kernel/shell.hpp"

namespace skein {

enum class InsertResult { kDone, kTooClose, kRefused };

/// Inserts points: the cavity starts from what contains the point, grows by the empty-sphere test in the new point's
/// metric (never through tagged faces), shrinks until it is star-shaped with elements above a quality floor, and is
/// coned. [Bowyer1981], [Watson1981], the chapter [35.2.3.2]; test in the metric: [GeorgeBorouchaki1998].
class Inserter {
 public:
  Inserter(Part& part, Cavity& cavity) : part_(&part), cavity_(&cavity) {}

  /// A point on edge (a, b) of t at a + s (b - a). Surface and feature edges are split as such; edges on the interface
  /// are refused.
  InsertResult on_edge(TetId t, VertId a, VertId b, double s);
  /// A point inside tetrahedron t (its barycentric weights positive), not nearer than `exclusion` (metric length) to
  /// any vertex of the cavity.
  InsertResult inside(TetId t, const std::array<double, 4>& weight, double exclusion);
  /// How poor elements a new point may leave: kLoose: half the quality of the worst that it replaces, as more points
  /// will follow; kStrict: none below Method::Insert::strict_floor that is worse than the worst of these.
  enum class Floor { kLoose, kStrict };
  void set_floor(Floor floor) noexcept { floor_ = floor; }
  /// Of the edge that was tried last; cut off where it was too large.
  [[nodiscard]] const Shell& shell() const noexcept { return shell_; }

 private:
  /// Of the gathered shell; nothing if the edge must not be split.
  [[nodiscard]] std::optional<EdgeKind> kind_of_edge() const noexcept;
  /// A new point may not split the faces round this edge.
  [[nodiscard]] bool must_stay(const Shell& shell) const noexcept;
  /// Where bodies touch along the edge: the shells of the edge in the others; false if one is too large.
  bool gather_other_fans(TetId t, VertId a, VertId b);
  [[nodiscard]] BoundaryPoint place_on_edge(VertId a, VertId b, double s, EdgeKind kind) const;
  /// Inserts a point of the edge (a, b), whose shells are gathered, at this place.
  InsertResult insert_on_edge(const BoundaryPoint& at, VertId a, VertId b, double s, EdgeKind kind);
  /// The facets of the shells and the feature edge become two each, with p between.
  void split_boundary(VertId p);
  void split_facets(const Shell& shell, VertId p);
  /// Q^3 of a tetrahedron on a face that can neither be split nor move, below which no new point presses it further: on
  /// a face that is longer than the metric asks for, there would always be room for one more, nearer to it.
  [[nodiscard]] double fixed_face_floor() const noexcept { return cube(part_->options.method.insert.fixed_face_floor); }
  InsertResult insert(VertId p, std::size_t seeds, double min_length);
  void grow(VertId p);
  /// The faces that the new point is joined to: into border_ and cone_.
  void collect_border();
  /// With QualityMeasure::kLeast: measures all elements of the cone so; false if one is below the floor.
  [[nodiscard]] bool cone_is_good(VertId p, double floor_q3);
  /// The i-th face of the border can neither be split nor move, and would get a poor element, worse than the old one.
  [[nodiscard]] bool is_pressed(std::size_t i) const noexcept;
  /// No face is pressed.
  [[nodiscard]] bool keeps_distance() const noexcept;
  bool shrink_and_cone(VertId p, std::size_t seeds, double floor_q3);
  [[nodiscard]] bool too_close(VertId p, double min_length);
  /// The same for the vertices behind the cavity's faces: where elements are bad, a near vertex need not be in the
  /// cavity.
  [[nodiscard]] bool neighbours_too_close(VertId p, double min_length);
  /// No vertex lies inside the cavity; link() is then what the new point gets edges to.
  [[nodiscard]] bool keeps_vertices();
  /// Every thin feature edge, but that which is split, is an edge of the border.
  [[nodiscard]] bool keeps_thin_edges() const;
  [[nodiscard]] bool is_on_border(VertId a, VertId b) const noexcept;
  /// Classifies the new edges (Part::edge_class).
  [[nodiscard]] bool link_too_close(VertId p, double min_length);
  void commit(VertId p);
  /// Of a tagged face: it is to be cut in two by the point on the edge.
  [[nodiscard]] bool is_split_face(FaceId f) const noexcept;
  [[nodiscard]] std::span<const VertId> link() const noexcept { return {link_.data(), n_link_}; }

  Part* part_;
  Cavity* cavity_;
  Cone cone_;
  Spheres spheres_;
  Shell shell_;
  std::vector<Shell> other_fans_;
  // Scratch; what is larger than it was ever needed stays as it is.
  std::vector<TetId> around_, fan_ball_;
  struct Outer {
    std::uint32_t old, side;
  };
  std::vector<Outer> outer_;
  std::vector<BorderFace> border_;
  std::vector<VertId> link_;
  std::size_t n_link_ = 0;
  bool on_edge_ = false;
  Floor floor_ = Floor::kLoose;
  bool walled_ = false;  ///< a tagged face of the shell lies in the cavity
};

}  // namespace skein
