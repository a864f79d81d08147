// Numbers at vertices, several per vertex, one vertex behind the other.
#pragma once
#include <cstddef>
#include <vector>

namespace skein {

/// Vertex by vertex the numbers of a, then those of b.
std::vector<double> side_by_side(const std::vector<double>& a, int width_a, const std::vector<double>& b, int width_b);

/// The numbers first .. first + n - 1 of each vertex.
std::vector<double> columns(const std::vector<double>& values, int width, int first, int n);

}  // namespace skein
