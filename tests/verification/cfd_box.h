// A fluid in a box, for verification: builds grid, layout and solver, sets fields from functions and measures errors.
#pragma once

#include <mpi.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>

#include "cfd/fluid_solver.h"
#include "cfd/parallel/ranks.h"

namespace twogrid {

inline const Interphase kNoParticles;

using Function = std::function<double(double x, double y, double z)>;

struct CfdBox {
  FineGrid grid;
  Layout layout;
  std::unique_ptr<FluidSolver> fluid;
  CellField<FineGrid> eps_begin, eps_end;  // own cells and halo

  using Cuts = std::array<std::vector<int>, 3>;

  /// Without cuts, ranks are dealt to the directions by MPI_Dims_create, at most one rank a cell.
  CfdBox(const std::array<std::vector<double>, 3>& nodes, const std::array<bool, 3>& periodic, const FluidSettings& s,
         MPI_Comm comm = MPI_COMM_WORLD, const Cuts* given = nullptr)
      : comm_(comm) {
    for (int d = 0; d < 3; ++d) grid.axis[d] = Axis(nodes[d], periodic[d]);
    const int ranks = ranks_of(comm);
    rank_ = rank_of(comm);
    Int3 dims{0, 0, 0};
    for (int d = 0; d < 3; ++d)
      if (grid.axis[d].n() < ranks) dims[d] = 1;
    MPI_Dims_create(ranks, 3, dims.data());
    Cuts cuts;
    for (int d = 0; d < 3; ++d) cuts[d] = given ? (*given)[d] : cuts_even(grid.axis[d], dims[d]);
    layout = Layout(grid, cuts);
    fluid = std::make_unique<FluidSolver>(comm, grid, layout, s);
    eps_begin.reset(fluid->void_fraction().box(), 1.0);
    eps_end.reset(fluid->void_fraction().box(), 1.0);
    fluid->start(eps_begin);
  }

  MPI_Comm comm() const { return comm_; }
  int rank() const { return rank_; }
  Box own() const { return layout.cells(rank_); }
  Vec3 face(int d, int i, int j, int k) const {
    Vec3 x{grid.axis[0].centre(i), grid.axis[1].centre(j), grid.axis[2].centre(k)};
    const Int3 q{i, j, k};
    x[d] = grid.axis[d].node(q[d]);
    return x;
  }
  Vec3 cell(int i, int j, int k) const {
    return {grid.axis[0].centre(i), grid.axis[1].centre(j), grid.axis[2].centre(k)};
  }
  void set(Array3<double>& field, const Function& f) const {
    for_each(field.box(), [&](int i, int j, int k) {
      const Vec3 x = cell(i, j, k);
      field(i, j, k) = f(x[0], x[1], x[2]);
    });
  }
  void set_faces(int d, Array3<double>& field, const Function& f) const {
    for_each(field.box(), [&](int i, int j, int k) {
      const Vec3 x = face(d, i, j, k);
      field(i, j, k) = f(x[0], x[1], x[2]);
    });
  }
  FaceField<FineGrid> face_field() const {
    FaceField<FineGrid> f;
    for (auto& c : f) c.reset(eps_begin.box());
    return f;
  }
  /// One interval of length dt with eps from eps_begin to eps_end (linear in time).
  FluidReport step(double dt, const Interphase& exchange = {}) {
    VoidFractionInTime path;
    path.begin = &eps_begin;
    path.end = &eps_end;
    return fluid->advance(dt, path, exchange);
  }
  Box faces(int d) const { return own().empty() ? Box{} : layout.faces(d, rank_); }
  /// All values of a face component on every rank, at index i + nx (j + ny k); nx etc. one more than the cells.
  std::vector<double> gathered(int d, const Array3<double>& field) const {
    const Int3 n = grid.n();
    std::vector<double> all(std::size_t(n[0] + 1) * (n[1] + 1) * (n[2] + 1), 0.0);
    for_each(faces(d), [&](int i, int j, int k) { all[at(i, j, k)] = field(i, j, k); });
    MPI_Allreduce(MPI_IN_PLACE, all.data(), int(all.size()), MPI_DOUBLE, MPI_SUM, comm_);
    return all;
  }
  /// The same for a cell field.
  std::vector<double> gathered(const Array3<double>& field) const {
    const Int3 n = grid.n();
    std::vector<double> all(std::size_t(n[0] + 1) * (n[1] + 1) * (n[2] + 1), 0.0);
    for_each(own(), [&](int i, int j, int k) { all[at(i, j, k)] = field(i, j, k); });
    MPI_Allreduce(MPI_IN_PLACE, all.data(), int(all.size()), MPI_DOUBLE, MPI_SUM, comm_);
    return all;
  }
  std::size_t at(int i, int j, int k) const {
    return std::size_t(i) + (grid.axis[0].n() + 1) * (std::size_t(j) + (grid.axis[1].n() + 1) * std::size_t(k));
  }
  double sum(double x) const {
    MPI_Allreduce(MPI_IN_PLACE, &x, 1, MPI_DOUBLE, MPI_SUM, comm_);
    return x;
  }
  double largest(double x) const {
    MPI_Allreduce(MPI_IN_PLACE, &x, 1, MPI_DOUBLE, MPI_MAX, comm_);
    return x;
  }
  /// Volume-weighted root mean square over own faces (cells) of all ranks.
  double face_error(int d, const Function& exact) const {
    double sum[2] = {0, 0};
    for_each(faces(d), [&](int i, int j, int k) {
      const Vec3 x = face(d, i, j, k);
      const double e = fluid->velocity()[d](i, j, k) - exact(x[0], x[1], x[2]),
                   V = fluid->measures().volume(d, i, j, k);
      sum[0] += e * e * V, sum[1] += V;
    });
    MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPI_DOUBLE, MPI_SUM, comm_);
    return std::sqrt(sum[0] / sum[1]);
  }
  /// Of p, up to a constant if free is set.
  double pressure_error(const Function& exact, bool free) const {
    double sum[3] = {0, 0, 0};
    for_each(own(), [&](int i, int j, int k) {
      const Vec3 x = cell(i, j, k);
      const double e = fluid->pressure()(i, j, k) - exact(x[0], x[1], x[2]), V = grid.volume(i, j, k);
      sum[0] += e * e * V, sum[1] += e * V, sum[2] += V;
    });
    MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPI_DOUBLE, MPI_SUM, comm_);
    const double mean = free ? sum[1] / sum[2] : 0;
    return std::sqrt(std::max(0.0, sum[0] / sum[2] - mean * mean));
  }

 private:
  MPI_Comm comm_;
  int rank_ = 0;
};

/// printf on rank 0 alone.
template <class... T>
void report(const char* format, T... values) {
  const int rank = rank_of(MPI_COMM_WORLD);
  if (rank == 0) std::printf(format, values...);
}

inline std::vector<double> uniform(double lo, double hi, int n) {
  return graded_nodes(lo, hi, n);
}

inline BoundaryCondition condition(BoundaryKind kind, Vec3 velocity = {0, 0, 0}, double pressure = 0) {
  BoundaryCondition c;
  c.kind = kind;
  c.velocity = velocity;
  c.pressure = pressure;
  return c;
}

}  // namespace twogrid
