// A rank that fails alone while the others wait for it: it is told so after a while, and ends the run itself.
#include <mpi.h>

#include <cstdio>
#include <new>

#include "comm/guest.hpp"

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  MPI_Comm world = MPI_COMM_WORLD;
  try {
    skein::run_as_guest(
        {&world},
        [](const skein::Comm& comm) {
          if (comm.rank() == skein::Rank{1}) throw std::bad_alloc();
          comm.barrier();
        },
        0.5);
  } catch (const skein::Error& e) {
    std::printf("code %d: %s\n", static_cast<int>(e.code()), e.what());
    std::fflush(stdout);
    MPI_Abort(MPI_COMM_WORLD, static_cast<int>(e.code()));
  }
  MPI_Finalize();
}
