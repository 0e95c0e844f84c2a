// Bodies in the output file: force and torque in every frame; with the field name `walls` their surfaces, with friction and
// pressure place by place, and the time means of both (output.h has the layout). Rank 0 writes them, in the order of the
// cells: the same on any number of ranks.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "cfd/grid/cell_table.h"
#include "coupling/output/xdmf.h"
#include "coupling/settings.h"

namespace twogrid {

class Fluid;
class GrowingFile;

/// The sums so far, by own cells. A copy is a checkpoint; for_each_entry() walks it by name, as CouplingState's does.
struct WallMeansState {
  static constexpr int kSums = 4;  ///< friction, pressure (Pa), times s
  double weight = 0;               // s
  CellTable<FineGrid> sums;

  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("weight", s.weight), f("sums", s.sums);
  }
};

class WallWriter {
 public:
  /// The fluid must live as long. Collective.
  WallWriter(MPI_Comm comm, const Fluid& fluid, const Settings& settings);

  bool has_surfaces() const { return shown_.facets > 0; }
  bool has_means() const { return state_.sums.columns() > 0; }
  WallMeansState& state() { return state_; }

  // Upper bounds of what the following add to the file (of all ranks), bytes.
  double bytes_of_bodies() const;
  double bytes_of_frame() const;
  double bytes_of_means() const { return has_surfaces() ? 32.0 * double(shown_.facets) + 16384 : 0; }
  /// Names and surfaces: /grid/bodies and /grid/walls. Collective.
  void write_bodies(GrowingFile& file) const;
  /// Adds to the frame that is there under /fluid/name, and /walls/name. Returns what ParaView is to show. Collective.
  XdmfSurface write_frame(GrowingFile& file, const std::string& name, double t, long step) const;
  /// Adds the present friction and pressure with this weight (s). Collective.
  void add(double weight);
  /// Forgets them. Local.
  void begin_means_anew();
  /// /average/walls. Collective.
  void write_means(GrowingFile& file) const;
  const XdmfSurface& shown() const { return shown_; }

 private:
  void sort_facets();
  /// Of all ranks, sorted, at rank 0: `components` values of each own facet.
  std::vector<double> gathered(const std::vector<double>& own, int components) const;
  void put(GrowingFile& file, const std::string& path, const std::vector<double>& own, int components,
           const char* unit) const;
  void put_at_rank_0(GrowingFile& file, const std::string& path, std::size_t rows,
                     const std::vector<int>& values) const;

  MPI_Comm comm_;
  int rank_ = 0;
  const Fluid& fluid_;
  std::vector<std::string> names_;
  XdmfSurface shown_;               // numbers of all ranks
  std::vector<std::size_t> order_;  // places of what all ranks send, one rank after the other; rank 0 only
  WallMeansState state_;
};

}  // namespace twogrid
