#include "shared_vertices.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace {

/// The numbers of all ranks, by rank.
std::vector<std::vector<std::int64_t>> gather(MPI_Comm comm, const std::vector<std::int64_t>& numbers) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  const int mine = static_cast<int>(numbers.size());
  std::vector<int> count(ranks), first(ranks + 1, 0);
  MPI_Allgather(&mine, 1, MPI_INT, count.data(), 1, MPI_INT, comm);
  std::partial_sum(count.begin(), count.end(), first.begin() + 1);
  std::vector<std::int64_t> all(first.back());
  MPI_Allgatherv(numbers.data(), mine, MPI_INT64_T, all.data(), count.data(), first.data(), MPI_INT64_T, comm);
  std::vector<std::vector<std::int64_t>> by_rank;
  for (int r = 0; r < ranks; ++r) by_rank.emplace_back(all.begin() + first[r], all.begin() + first[r + 1]);
  return by_rank;
}

}  // namespace

SharedVertices::SharedVertices(MPI_Comm comm, const std::vector<std::int64_t>& local2global) : comm_(comm) {
  MPI_Comm_rank(comm, &rank_);
  std::vector<int> by_number(local2global.size());  // the order that all ranks know
  std::iota(by_number.begin(), by_number.end(), 0);
  std::sort(by_number.begin(), by_number.end(), [&](int a, int b) { return local2global[a] < local2global[b]; });
  auto numbers = gather(comm, local2global);
  shared_.resize(numbers.size());
  for (int r = 0; r < static_cast<int>(numbers.size()); ++r) {
    if (r == rank_) continue;
    std::sort(numbers[r].begin(), numbers[r].end());
    std::copy_if(by_number.begin(), by_number.end(), std::back_inserter(shared_[r]),
                 [&](int v) { return std::binary_search(numbers[r].begin(), numbers[r].end(), local2global[v]); });
  }
}

void SharedVertices::sum(std::vector<double>& values) const {
  const int ranks = static_cast<int>(shared_.size());
  std::vector<std::vector<double>> sent(ranks), received(ranks);
  std::vector<MPI_Request> requests;
  for (int r = 0; r < ranks; ++r) {
    for (const int v : shared_[r]) sent[r].push_back(values[v]);
    received[r].resize(sent[r].size());
    const int n = static_cast<int>(sent[r].size());
    MPI_Irecv(received[r].data(), n, MPI_DOUBLE, r, 0, comm_, &requests.emplace_back());
    MPI_Isend(sent[r].data(), n, MPI_DOUBLE, r, 0, comm_, &requests.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);

  const std::vector<double> own = std::exchange(values, std::vector<double>(values.size(), 0.0));
  for (int r = 0; r < ranks; ++r) {
    for (std::size_t i = 0; i < shared_[r].size(); ++i) values[shared_[r][i]] += received[r][i];
    for (std::size_t v = 0; r == rank_ && v < own.size(); ++v) values[v] += own[v];
  }
}
