// What a run leaves behind: one HDF5 file with its record, the two grids, the frames and the time means, and beside it
// XDMF files that open it in ParaView. Written by all ranks together; complete on disk after every frame. A file that is
// there is never destroyed unasked; a run that goes on from a checkpoint goes on in its file (run_files.h).
//
//   /record                 attributes: version, commit, versions of libraries, ranks, date, settings, run (an id);
//                           input_text: the script
//   /record/settings        attributes: all settings, those by default included, each by its keyword as a script has it
//   /record/leg_N           attributes: date, commit, ranks, command line and step of the checkpoint that the run went on
//                           from in this file; N = 2, 3, ...
//   /grid/x,y,z             nodes of the fine grid (m)
//   /particle_grid/x,y,z    nodes of the particle grid (m); attribute ratio
//     theta, blank          in both where bodies cut the grids: open share of a cell's volume; 32 where it is 0 (ParaView
//                           leaves such cells out). Values of cells, and means over blocks, are of the open part.
//   /grid/bodies            with bodies: attribute names; centre [bodies][3], about which torques are
//   /grid/walls             with the field name `walls`: the bodies' surfaces, a facet a cut cell: body (from 0), area (m2),
//                           normal (into the fluid), centre (m); points and polygons (3, number of corners, corners)
//   /fluid/NNNNNN/          frame NNNNNN (000000, 000001, ...):
//     time, step            s; DEM step
//     u    [nz][ny][nx][3]  interstitial velocity at cell centres (m/s), mean of the cell's two faces
//     p, eps [nz][ny][nx]   dynamic pressure (Pa), void fraction; likewise fields of models, by their names
//     faces/                with the field name `faces`: ux, uy, uz (m/s) on the faces, as the solver holds them.
//                           [i] is the low face of cell i; in a direction that is not periodic there is one more, the
//                           high side. Where the solver keeps them, also flux_x, flux_y, flux_z (eps u of the last
//                           step, m/s) and deps_dt (d(eps)/dt less the volume source, 1/s): deps_dt + div(flux) = 0 in
//                           every cell.
//     bodies/               force, of it friction (N), and torque (N m) [bodies][3] of the fluid on them, means over the
//                           last coupling interval; 0 before the first
//   /walls/NNNNNN/          time, step, friction [facets][3] (Pa, on the body), pressure [facets] (dynamic, at the wall, Pa),
//                           both as measured at that time (cfd/bodies/wall_stress.h); force [bodies][3]: their sums (N)
//   /particles/NNNNNN/      time, step and, one row a particle, position, velocity, force (of all forces), drag,
//                           pressure_force, radius, eps, id. Rows are in no order: sort by id to follow a particle.
//                           Names and shapes are those of H5MD (de Buyl, Colberg & Hoefling 2014); other than there
//                           every frame is a group of its own, as the number of particles may change.
//   /average/               attributes from, to (s), weight (s of samples), samples; where batches tell them: relative
//                           standard errors of void fraction and gas flux, correlation_time (s). See averages.h; fine/... and particle_grid/... with batch/...; walls/friction, pressure
#pragma once

#include <mpi.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "coupling/particles/particles.h"
#include "coupling/settings.h"

namespace twogrid {

class Fluid;

/// What only the caller knows about the run. Rank 0's counts.
struct Record {
  std::string input_text;  ///< of the script
  std::string command_line;
  std::vector<std::pair<std::string, std::string>> versions;  ///< name, version of libraries (LIGGGHTS, PETSc)
  std::vector<std::pair<std::string, std::string>> settings;  ///< keyword of the script, its value as a script has it
};

/// Names that `output fields` may have; those of models (Fluid::model_fields()) come on top.
const std::vector<std::string>& output_fields();
/// Throws std::invalid_argument with a sentence when the settings can't be right, but for names of fields. Local.
void check(const OutputSettings& settings);

/// What must outlive a process for the output to go on; the means have a state of their own (averages.h). A copy is a
/// checkpoint; for_each_entry() walks it by name, as CouplingState's does.
struct OutputState {
  double run_high = 0, run_low = 0;  // id of the run, 32 bits each; 0, 0: it has not begun

  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("run_high", s.run_high), f("run_low", s.run_low);
  }
};

class Averages;
class StartUp;
struct WallMeansState;

class Output {
 public:
  /// Touches no file. The fluid must live as long. Throws std::invalid_argument with a sentence on all ranks when the
  /// settings can't be right.
  Output(MPI_Comm comm, const Settings& settings, const Fluid& fluid, const Record& record);
  ~Output();

  /// To be called before all of the following; later calls do nothing. Makes the file, with record and grids. With a state
  /// restored from a checkpoint the run goes on in the file that is there, whose frames after step `last` are dropped; step:
  /// that of the checkpoint. Keeps other runs off the file. Returns what the user should know, in sentences. Collective.
  /// Throws std::runtime_error with a sentence on all ranks where a file of that name is there and is not to be
  /// overwritten, is another run's, is being written by another process, or can't be made.
  std::vector<std::string> begin(long step, long last);
  OutputState& state();
  Averages* averages();          ///< Null: none wanted.
  WallMeansState* wall_means();  ///< The same.
  StartUp* start_up();           ///< Null: not to be found.
  double&
  means_anew();  ///< The fluid's time (s) at which a run had the means begin anew; 0: none had. To be kept, too.

  /// For the run that begins: whether anything drives the fluid through the domain. Without a call: yes.
  void set_driven(bool driven);
  /// The means begin anew, from then on and until then as these settings say. There must have been means before.
  void average_as(const OutputSettings& settings);
  /// The run that begins has other conditions of the flow than the one before had at its end: with `average from auto` start-up
  /// and means begin anew. Returns what is to be said, as a sentence that begins with `what`; warns: as a warning.
  std::string meet_other_conditions(const std::string& what, bool* warns);

  /// Adds a frame of the fields at time t (s), DEM step `step`, and the means so far. Collective. Throws
  /// std::runtime_error with a sentence on all ranks when it can't be written.
  void frame(double t, long step, const Particles& particles);
  /// Adds the present fields to the means, for a time of `weight` s, if the fluid's time has reached `average from`, or
  /// start-up is over (start_up.h). pressure_drop (Pa): of the last interval. Returns what the user should know, mostly
  /// nothing. No message; with `auto` or `until` it is collective.
  std::string average(double weight, const Particles& particles, double pressure_drop);
  /// Whether the means are as sure as `until` wants; known anew when a batch has become full.
  bool sure_enough() const;
  /// Samples to come, at least 1, before sure_enough() can change.
  long long samples_to_decide() const;
  /// What is known of the means' errors, as a sentence; empty: nothing. Collective.
  std::string sureness() const;
  /// Writes the means. To be called at the end of every run; more frames and another run may follow. Collective.
  void finish();
  /// What has been written so far is on the disk, whatever happens to the machine. Returns a sentence where it isn't.
  /// Collective.
  std::string sync();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twogrid
