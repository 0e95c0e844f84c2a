// Time means of the gas on the fine grid, and of gas and solids on the particle grid, summed up during the run.
//
// Sums of weight * value are kept; the weight is the time (s) a sample stands for. On the particle grid a gas value is
// the volume mean over the block of fine cells, and a particle counts with its volume in the cell that holds its
// centre.
//
// Batches: the particle grid's sums are also kept in up to 16 consecutive batches of equally many samples. When all are
// full, neighbours are merged and the batches to come are twice as long: whatever the length of the run there are
// 8 to 16 of them at its end, and the scatter of their means gives the error of any mean or profile (batch means;
// Conway 1963; as an estimate it needs batches longer than the flow's memory).
#pragma once

#include <mpi.h>

#include <array>
#include <string>
#include <vector>

#include "cfd/fluid/fluid.h"
#include "coupling/particles/particles.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

class Hdf5File;

class Averages {
 public:
  static constexpr int kBatches = 16;

  /// fine must live as long; coarse is copied. Local.
  Averages(MPI_Comm comm, const FineGrid& fine, const Layout& layout, const ParticleGrid& coarse);

  /// Adds the present fields with this weight (s). No message; no allocation unless a particle is farther from the
  /// rank's cells than any before. Particles whose centre lies outside the fluid's domain don't count.
  void add(double weight, const Fluid& fluid, const Particles& particles);

  double weight() const { return weight_; }
  /// Upper bound of what write() adds to a file that has no means yet (of all ranks), bytes.
  double bytes() const;
  /// Writes /average, in place of what an earlier call wrote. Solids beyond the rank's own cells are sent to their
  /// owner. Collective. The sums stay as they are.
  void write(Hdf5File& file) const;

 private:
  enum { kFineEps, kFineP, kFineU, kFineFlux = 5, kFineEps2 = 8, kFineP2, kFineU2, kFineSums = 13 };
  enum { kGasEps, kGasP, kGasU, kGasBatchSums = 5, kGasFlux = 5, kGasEps2 = 8, kGasP2, kGasU2, kGasSums = 13 };
  enum { kSolidsVolume, kSolidsFlux, kSolidsBatchSums = 4, kSolidsV2 = 4, kSolidsSums = 7 };

  void next_batch();
  void add_gas(double weight, const Fluid& fluid);
  void add_solids(double weight, const Particles& particles);
  void grow_window(const Int3& cell);

  MPI_Comm comm_;
  const FineGrid& fine_;
  ParticleGrid coarse_;
  Layout coarse_layout_;
  Box fine_own_, coarse_own_;

  double weight_ = 0;
  long samples_ = 0;
  std::array<double, kBatches> batch_weight_{};
  int batch_ = 0;           // the one being filled
  long batch_length_ = 1;   // samples
  long batch_samples_ = 0;  // in the one being filled

  // By own cell, x fastest. Sums of the whole run, and of each batch the first kGasBatchSums.
  std::vector<std::array<double, kFineSums>> fine_sum_;
  std::vector<std::array<double, kGasSums>> gas_sum_;
  std::array<std::vector<std::array<double, kGasBatchSums>>, kBatches> gas_batch_;
  // On a window of the particle grid that covers the own cells and every particle met so far.
  std::array<Array3<double>, kSolidsSums> solids_sum_;
  std::array<std::array<Array3<double>, kSolidsBatchSums>, kBatches> solids_batch_;
};

}  // namespace twogrid
