// Time means of the gas on the fine grid, and of gas and solids on the particle grid, summed up during the run.
//
// Sums of weight * value are kept; the weight is the time (s) a sample stands for. On the particle grid a gas value is
// the volume mean over the block of fine cells (over its open part, where bodies cut it), and a particle counts with its
// volume in the cell that holds its centre.
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
#include "cfd/grid/cell_table.h"
#include "coupling/particles/particles.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

class GrowingFile;

/// The sums so far, by own cells. A copy is a checkpoint; for_each_entry() walks it by name, as CouplingState's does.
struct AveragesState {
  static constexpr int kBatches = 16;

  double weight = 0;  // s
  long long samples = 0;
  std::array<double, kBatches> batch_weight{};
  int batch = 0;                // the one being filled
  long long batch_length = 1;   // samples
  long long batch_samples = 0;  // in the one being filled
  CellTable<FineGrid> fine;
  CellTable<ParticleGrid> gas, solids;
  std::array<CellTable<ParticleGrid>, kBatches> gas_batch, solids_batch;

  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("weight", s.weight), f("samples", s.samples), f("batch", s.batch), f("batch_length", s.batch_length);
    f("batch_samples", s.batch_samples), f("fine", s.fine), f("gas", s.gas), f("solids", s.solids);
    for (int b = 0; b < kBatches; ++b) {
      const std::string n = std::to_string(b);
      f(("batch_weight_" + n).c_str(), s.batch_weight[b]), f(("gas_batch_" + n).c_str(), s.gas_batch[b]);
      f(("solids_batch_" + n).c_str(), s.solids_batch[b]);
    }
  }
};

/// How sure the means on the particle grid are, from the scatter of their full batches: root mean squares over the cells, each
/// counted with its mean volume of solids (where there are none: with its open volume).
struct MeansError {
  static constexpr double kAlike = 0.3;      ///< neighbours' correlation from which on scatter says too little
  static constexpr double kRoundOff = 1e-9;  ///< scatter of batches that says that nothing changes
  static constexpr double kDriftOver = 2;    ///< see bounded()

  int batches = 0;           ///< full ones; below AveragesState::kBatches / 2 nothing below is known
  double batch_time = 0;     ///< length of one (s)
  double eps = 0, flux = 0;  ///< standard errors of void fraction and gas flux over their own means
  double scatter = 0;        ///< of a single batch's means, over the means: the larger of the two
  double correlation_time =
      0;  ///< of void fraction and gas velocity: integral of their correlation over lags above 0 (s); 0 within round-off
  double lag = 0;     ///< correlation of neighbouring batches, by which the errors have been made larger
  double passes = 0;  ///< so often the gas has passed the domain's longest side in the means' time

  bool known() const { return batches >= AveragesState::kBatches / 2; }
  bool long_enough() const { return batch_time >= 4 * correlation_time; }
  /// Batches long enough against the flow's memory for their scatter to be what the errors are made of.
  bool trusted() const { return known() && long_enough() && lag < kAlike; }
  bool steady() const { return known() && scatter <= kRoundOff; }
  /// However alike neighbours are, as in a slow change: a mean of batches scatters no more than one of them. Of a change along
  /// a straight line through all batches the end is off by sqrt(3) scatters, hence the factor. What is slower than all of them
  /// together they can't show: they must be of a time that the caller finds long enough.
  bool bounded(double relative) const { return known() && kDriftOver * scatter <= relative; }
  /// long_time: see bounded().
  bool within(double relative, bool long_time) const {
    return (trusted() && eps <= relative && flux <= relative) || (long_time && (steady() || bounded(relative)));
  }
};

class Averages {
 public:
  static constexpr int kBatches = AveragesState::kBatches;

  /// fine must live as long; coarse, with its open part, is copied. Local.
  Averages(MPI_Comm comm, const FineGrid& fine, const Layout& layout, const ParticleGrid& coarse);

  /// Adds the present fields with this weight (s). No message; no allocation unless a particle is farther from the
  /// rank's cells than any before. Particles whose centre lies outside the fluid's domain don't count. A sample's sum over
  /// the particles of a cell does not depend on their order.
  void add(double weight, const Fluid& fluid, const Particles& particles);

  double weight() const { return state_.weight; }
  /// Samples to come until the batch in hand is full.
  long long samples_to_full_batch() const { return state_.batch_length - state_.batch_samples; }
  /// at_rest: speed (m/s) up to which the gas counts as at rest, where nothing drives it: fluxes below are no measure of
  /// their errors. Collective.
  MeansError error(double at_rest = 0) const;
  /// Forgets all samples. Local.
  void begin_anew();
  /// Upper bound of what write() adds to a file that has no means yet (of all ranks), bytes.
  double bytes() const;
  /// Writes /average, in place of what an earlier call wrote. Collective. The sums stay as they are.
  void write(GrowingFile& file) const;

  /// Sends what has been summed for other ranks' cells to them, so that state() is complete. To be called in the run that
  /// goes on just as in the one that is restarted, since this decides in which order is added. Collective.
  void gather();
  /// To be saved after gather(), or filled before the first sample.
  AveragesState& state() { return state_; }

 private:
  enum { kFineEps, kFineP, kFineU, kFineFlux = 5, kFineEps2 = 8, kFineP2, kFineU2, kFineSums = 13 };
  enum { kGasEps, kGasP, kGasU, kGasFlux = 5, kGasBatchSums = 8, kGasEps2 = 8, kGasP2, kGasU2, kGasSums = 13 };
  enum { kSolidsVolume, kSolidsFlux, kSolidsBatchSums = 4, kSolidsV2 = 4, kSolidsSums = 7 };

  void next_batch();
  void add_gas(double weight, const Fluid& fluid);
  void add_solids(double weight, const Particles& particles);
  void grow_window(const Int3& cell);
  /// What is in the window, at the owners: the sums, then those of the batches. Collective.
  std::vector<Array3<double>> window_at_owners() const;
  std::vector<Array3<double>> all_solids() const;

  MPI_Comm comm_;
  const FineGrid& fine_;
  ParticleGrid coarse_;
  Layout coarse_layout_;
  Box fine_own_, coarse_own_;

  AveragesState state_;
  // On a window of the particle grid that covers the own cells and every particle met so far: the solids' sums of cells
  // that are not own, of the run and of batches, and one sample's sums in multiples of a unit.
  Box window_;
  std::array<Array3<double>, kSolidsSums> beyond_sum_;
  std::array<std::array<Array3<double>, kSolidsBatchSums>, kBatches> beyond_batch_;
  std::vector<std::array<long long, kSolidsSums>> sample_;
  std::vector<double> width_, open_width_;  // in x: of own fine cells; of the open parts of a block's row (m)
};

}  // namespace twogrid
