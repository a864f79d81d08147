// The MPI communicator of a caller, handed through rooms that do not know MPI.
#pragma once

namespace skein {

/// Points to a caller's MPI_Comm, whatever type that is in this MPI.
struct MpiHandle {
  const void* mpi_comm = nullptr;
};

}  // namespace skein
