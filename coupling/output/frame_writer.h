// One frame in the output file: the fluid on its cells, the particles a row each (output.h has the layout).
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "coupling/output/xdmf.h"
#include "coupling/particles/particles.h"
#include "coupling/settings.h"

namespace twogrid {

class Fluid;
class GrowingFile;
struct ParticleGrid;

class FrameWriter {
 public:
  /// settings: their fields are those to write. The fluid must live as long.
  FrameWriter(MPI_Comm comm, const Fluid& fluid, const OutputSettings& settings);
  /// Counts the particles that will be written. Returns an upper bound of what the frame adds to the file, bytes.
  /// Collective.
  double count(const Particles& particles);
  /// Where bodies cut the grids: open shares of their cells into /grid and /particle_grid, and which cells ParaView is to
  /// leave out. nodes: with their open part. Collective.
  void write_open_shares(GrowingFile& file, const ParticleGrid& nodes);
  /// Upper bound of what it adds to the file, bytes.
  double bytes_of_open_shares(const ParticleGrid& nodes) const;
  /// Writes the particles counted, under /fluid/name and /particles/name. Returns what ParaView is to show of it, without
  /// the file's name. Collective.
  XdmfFrame write(GrowingFile& file, const std::string& name, double t, long step, const Particles& particles);

 private:
  void write_fluid(GrowingFile& file, const std::string& at);
  void write_faces(GrowingFile& file, const std::string& at);
  void write_particles(GrowingFile& file, const std::string& at, const Particles& particles);
  bool wants(const std::string& field) const;

  MPI_Comm comm_;
  int rank_;
  const Fluid& fluid_;
  OutputSettings settings_;
  Int3 n_;
  Box own_;
  std::vector<double> buffer_;
  struct {
    long long own = 0, before = 0, total = 0;
    int has_tag = 0, has_state = 0, has_force = 0;
  } count_;
};

}  // namespace twogrid
