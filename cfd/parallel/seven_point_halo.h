// Halo of one cell on the six sides of a rank's block, without edges and corners: all that a 7-point stencil reads.
// Fewer messages than BlockExchange with a grown box (at most six neighbours on a tensor-product layout), no allocation
// in a call, and cells of one colour alone if asked for.
#pragma once

#include <mpi.h>

#include <array>
#include <cstddef>
#include <initializer_list>
#include <vector>

#include "cfd/grid/box.h"

namespace twogrid {

class SevenPointHalo {
 public:
  /// Largest number of arrays in one call.
  static constexpr int kMaxArrays = 3;
  enum class Cells { kRed = 0, kBlack = 1, kAll = 2 };  ///< colour: parity of i + j + k of the owner's cell

  SevenPointHalo() = default;
  /// All ranks give the same arguments. owned[r]: cells of rank r, of a grid of n cells. The arrays of the calls below
  /// cover owned.grown(width), width at least 1, or 0 where nothing lies beyond; a rank that owns nothing may give
  /// empty ones.
  SevenPointHalo(MPI_Comm comm, const std::vector<Box>& owned, const Int3& n, const std::array<bool, 3>& periodic,
                 const Int3& width = {1, 1, 1});

  /// Halo <- owners' values; beyond a side that is not periodic the halo is left alone. Collective among neighbours.
  template <class T>
  void bring(std::initializer_list<Array3<T>*> arrays, Cells cells = Cells::kAll);
  /// Owners' values += the halo's. The transpose of bring; the halo keeps its values. Collective among neighbours.
  template <class T>
  void add(Array3<T>& array);

 private:
  struct Peer {
    int rank = 0;
    std::vector<int> give;  // memory indices of own cells the peer sees, red ones first
    std::vector<int> take;  // memory indices of halo cells the peer owns, red ones first
    int give_red = 0, take_red = 0;
    std::vector<unsigned char> out, in;
  };
  struct Range {
    int begin, end;
  };
  static Range range(int red, int all, Cells c) {
    return c == Cells::kRed ? Range{0, red} : c == Cells::kBlack ? Range{red, all} : Range{0, all};
  }

  MPI_Comm comm_ = MPI_COMM_NULL;
  std::vector<Peer> peers_;
  Peer self_;  // periodic images of own cells
  std::vector<MPI_Request> requests_;
};

}  // namespace twogrid
