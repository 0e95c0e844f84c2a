// Moves values between the owners of a grid's cells (or faces) and the boxes in which ranks want them: halos around own
// blocks, and windows anywhere (where a rank's particles are). Periodic images included. Set up once; each call is one
// message per pair of ranks that share something, for all arrays given together.
#pragma once

#include <mpi.h>

#include <array>
#include <vector>

#include "cfd/grid/box.h"
#include "cfd/parallel/vectorised.h"

namespace twogrid {

/// One of several values (or groups) that lie together for every cell of a box: that of cell m at data[stride * m].
template <class T>
struct Slot {
  Box box;
  T* data;
  int stride;
  std::ptrdiff_t index(int i, int j, int k) const {
    return (i - box.lo[0]) +
           std::ptrdiff_t(box.size(0)) * ((j - box.lo[1]) + std::ptrdiff_t(box.size(1)) * (k - box.lo[2]));
  }
};

class BlockExchange {
 public:
  BlockExchange() = default;
  /// Collective only in that all ranks must give the same arguments.
  /// owned[r]: what rank r owns (disjoint). wanted[r]: the box rank r wants, which may reach outside [0, extent): in a
  /// periodic direction that is the periodic image (period = extent of CELLS), elsewhere there is no owner and the
  /// value is left alone.
  BlockExchange(MPI_Comm comm, const std::vector<Box>& owned, const std::vector<Box>& wanted, const Int3& period,
                const std::array<bool, 3>& periodic);

  /// window <- owners' values. The arrays must cover the rank's owned and wanted box. Collective.
  template <class T>
  void bring(const std::vector<const Array3<T>*>& owner, const std::vector<Array3<T>*>& window) const;
  /// The same; the window may lie around the owned box in one and the same memory, here and in add().
  template <class T>
  void bring(const std::vector<Slot<T>>& owner, const std::vector<Slot<T>>& window) const;
  /// owners' values += windows' values, own window included, in rank order. Exact for integers. Collective.
  template <class T>
  void add(const std::vector<const Array3<T>*>& window, const std::vector<Array3<T>*>& owner) const;
  template <class T>
  void add(const std::vector<Slot<T>>& window, const std::vector<Slot<T>>& owner) const;
  /// Halo of arrays that hold both own values and halo. Collective.
  template <class T>
  void bring(const std::vector<Array3<T>*>& field) const;
  template <class T>
  void bring(Array3<T>& field) const {
    bring(std::vector<Array3<T>*>{&field});
  }

 private:
  struct Piece {
    Box owner;   // indices at the owner
    Int3 shift;  // index in the window = index at the owner + shift
  };
  struct Peer {
    int rank;
    std::vector<Piece> pieces;
    std::size_t count;
  };
  template <class T, class Source, class Target>
  void transfer(const std::vector<Peer>& from, const std::vector<Peer>& to, const std::vector<Source>& source,
                const std::vector<Target>& target, bool to_window, bool accumulate, bool in_place) const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0;
  std::vector<Peer> send_;     // of owned values that others (or this rank's window) want
  std::vector<Peer> receive_;  // of wanted values, by owner
  std::vector<Piece> self_;
  mutable std::vector<FourNumbers> in_, out_;  // messages: kept, so that a transfer allocates nothing
  mutable std::vector<MPI_Request> request_;   // of those from others, then of those to others

  friend class FaceExchange;
};

/// Halos of the three components of a face field, in one message per pair of ranks.
class FaceExchange {
 public:
  FaceExchange() = default;
  /// As for BlockExchange, for each direction d.
  FaceExchange(MPI_Comm comm, const std::array<std::vector<Box>, 3>& owned,
               const std::array<std::vector<Box>, 3>& wanted, const Int3& period, const std::array<bool, 3>& periodic);

  /// The arrays hold own values and halo. Collective.
  void bring(const std::array<Array3<double>*, 3>& field) const;
  template <class Field>
  void bring(Field& field) const {
    bring(std::array<Array3<double>*, 3>{&field[0], &field[1], &field[2]});
  }

 private:
  struct Joint {
    int rank;
    std::array<int, 3> peer;  // index in the direction's list, or -1
    std::size_t count;
  };
  static std::vector<Joint> join(const std::array<const std::vector<BlockExchange::Peer>*, 3>& lists);

  MPI_Comm comm_ = MPI_COMM_NULL;
  std::array<BlockExchange, 3> part_;
  std::vector<Joint> send_, receive_;
  mutable std::vector<FourNumbers> in_, out_;
  mutable std::vector<MPI_Request> request_;
};

}  // namespace twogrid
