// Gathering to rank 0 and scattering in even slices.
#include "generate/slices.hpp"

#include "comm/exchange.hpp"
#include "comm/file.hpp"

namespace skein {
namespace {

template <class T>
std::vector<T> scatter(const Comm& comm, std::int64_t total, const std::vector<T>& whole, std::size_t width = 1) {
  Packets<T> send;
  if (comm.is_root() && total > 0) {
    for (int r = 0; r < comm.size(); ++r) {
      const Slice slice = even_slice(total, Rank{r}, comm.size());
      if (slice.size() == 0) continue;
      send.rank.push_back(Rank{r});
      send.offset.push_back(static_cast<std::size_t>(slice.last) * width);
    }
    send.items = whole;
  }
  Packets<T> got = skein::exchange(comm, send);
  return std::move(got.items);
}

template <std::size_t N>
EntitySlice<N> gather(const Comm& comm, const EntitySlice<N>& slice) {
  return {slice.total, 0, comm.gather(slice.verts), comm.gather(slice.ref)};
}

VertexListSlice gather(const Comm& comm, const VertexListSlice& slice) {
  return {slice.total, 0, comm.gather(slice.verts)};
}

template <std::size_t N>
EntitySlice<N> scatter(const Comm& comm, const EntitySlice<N>& whole) {
  const auto total = comm.broadcast(whole.total);
  return {total, even_slice(total, comm.rank(), comm.size()).first, scatter(comm, total, whole.verts),
          scatter(comm, total, whole.ref)};
}

VertexListSlice scatter(const Comm& comm, const VertexListSlice& whole) {
  const auto total = comm.broadcast(whole.total);
  return {total, even_slice(total, comm.rank(), comm.size()).first, scatter(comm, total, whole.verts)};
}

}  // namespace

MeshSlice gather_surface(const Comm& comm, const MeshSlice& slice) {
  MeshSlice whole;
  whole.path = slice.path;
  whole.total_verts = slice.total_verts;
  whole.coords = comm.gather(slice.coords);
  whole.vert_ref = comm.gather(slice.vert_ref);
  whole.edges = gather(comm, slice.edges);
  whole.triangles = gather(comm, slice.triangles);
  whole.corners = gather(comm, slice.corners);
  whole.ridges = gather(comm, slice.ridges);
  whole.required_verts = gather(comm, slice.required_verts);
  whole.required_edges = gather(comm, slice.required_edges);
  whole.required_triangles = gather(comm, slice.required_triangles);
  return whole;
}

MeshSlice scatter_mesh(const Comm& comm, const MeshSlice& whole) {
  MeshSlice slice;
  slice.path = comm.broadcast(whole.path);
  slice.total_verts = comm.broadcast(whole.total_verts);
  slice.first_vert = even_slice(slice.total_verts, comm.rank(), comm.size()).first;
  slice.coords = scatter(comm, slice.total_verts, whole.coords);
  slice.vert_ref = scatter(comm, slice.total_verts, whole.vert_ref);
  slice.edges = scatter(comm, whole.edges);
  slice.triangles = scatter(comm, whole.triangles);
  slice.tets = scatter(comm, whole.tets);
  slice.corners = scatter(comm, whole.corners);
  slice.ridges = scatter(comm, whole.ridges);
  slice.required_verts = scatter(comm, whole.required_verts);
  slice.required_edges = scatter(comm, whole.required_edges);
  slice.required_triangles = scatter(comm, whole.required_triangles);
  return slice;
}

std::vector<double> scatter_values(const Comm& comm, std::int64_t total_verts, int width,
                                   const std::vector<double>& whole) {
  return scatter(comm, total_verts, whole, static_cast<std::size_t>(width));
}

}  // namespace skein
