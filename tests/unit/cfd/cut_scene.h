// A grid that bodies cut, for unit tests: all ranks' numbers together, and meshes to cut it with.
#pragma once

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "cfd/bodies/cut_grid.h"
#include "cfd/bodies/simple_shapes.h"
#include "cfd/bodies/triangle_set.h"
#include "cfd/grid/pi.h"
#include "cfd/parallel/ranks.h"

namespace twogrid {

struct CutScene {
  FineGrid grid;
  Layout layout;
  FluidSettings settings;
  OpenSpace space;
  CutReport report;
  MPI_Comm comm;

  /// Periodic or with walls around, until the settings say otherwise; run() cuts.
  CutScene(const std::array<std::vector<double>, 3>& nodes, const std::array<bool, 3>& periodic,
           std::vector<Body> bodies, MPI_Comm c = MPI_COMM_WORLD)
      : comm(c) {
    for (int d = 0; d < 3; ++d) grid.axis[d] = Axis(nodes[d], periodic[d]);
    const int ranks = ranks_of(comm);
    Int3 dims{0, 0, 0};
    for (int d = 0; d < 3; ++d)
      if (grid.axis[d].n() < ranks) dims[d] = 1;
    MPI_Dims_create(ranks, 3, dims.data());
    std::array<std::vector<int>, 3> cuts;
    for (int d = 0; d < 3; ++d) cuts[d] = cuts_even(grid.axis[d], dims[d]);
    layout = Layout(grid, cuts);
    settings.density = 1, settings.viscosity = 1e-3;
    for (int s = 0; s < 6; ++s) {
      settings.side[s].resize(1);
      settings.side[s][0].kind = periodic[s / 2] ? BoundaryKind::kPeriodic : BoundaryKind::kNoSlip;
    }
    settings.bodies = std::move(bodies);
  }
  CutScene& run() {
    const int rank = rank_of(comm);
    space = OpenSpace();
    for (int d = 0; d < 3; ++d) space.alpha[d].reset(layout.faces(d, rank), 1.0);
    space.theta.reset(layout.cells(rank), 1.0);
    report = cut_grid(comm, grid, layout, settings, space);
    return *this;
  }
  /// The sentence with which the cutting ends; empty if it doesn't.
  std::string sentence() {
    try {
      run();
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "";
  }
  CutScene& side(int s, BoundaryKind kind) {
    settings.side[s][0].kind = kind;
    return *this;
  }
  CutScene& fluid_at(const Vec3& x) {
    settings.fluid_at.push_back(x);
    return *this;
  }
  Box own() const { return layout.cells(rank_of(comm)); }
  Box faces(int d) const { return layout.faces(d, rank_of(comm)); }
  std::size_t at(const Int3& x) const {
    return std::size_t(x[0]) + (grid.n()[0] + 1) * (std::size_t(x[1]) + (grid.n()[1] + 1) * std::size_t(x[2]));
  }
  std::vector<double> none() const {
    return std::vector<double>(std::size_t(grid.n()[0] + 1) * (grid.n()[1] + 1) * (grid.n()[2] + 1), 0.0);
  }
  std::vector<double> added(std::vector<double> all) const {
    MPI_Allreduce(MPI_IN_PLACE, all.data(), int(all.size()), MPI_DOUBLE, MPI_SUM, comm);
    return all;
  }
  template <class A>
  std::vector<double> gathered(const Box& box, const A& array) const {
    std::vector<double> all = none();
    for_each(box, [&](int i, int j, int k) { all[at({i, j, k})] = array(i, j, k); });
    return added(all);
  }
  std::vector<double> alpha(int d) const { return gathered(faces(d), space.alpha[d]); }
  std::vector<double> links(int d) const { return gathered(faces(d), space.links[d]); }
  std::vector<double> theta() const { return gathered(own(), space.theta); }
  /// Sum of the pieces' conductances of every face.
  std::vector<double> conductance(int c) const {
    std::vector<double> all = none();
    for (const WallPiece& p : space.pieces)
      if (p.component == c) all[at(p.face)] += p.conductance;
    return added(all);
  }
  /// Area of walls in every cell along d.
  std::vector<double> wall(int d) const {
    std::vector<double> all = none();
    for (const WallCell& w : space.surface) all[at(w.cell)] += w.area[d];
    return added(all);
  }
  /// Open area of the grid's plane of faces `at` normal to d.
  double open_area(int d, int plane) const {
    double sum = 0;
    for_each(faces(d), [&](int i, int j, int k) {
      if (Int3{i, j, k}[d] == plane) sum += space.alpha[d](i, j, k) * grid.area(d, i, j, k);
    });
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm);
    return sum;
  }
  Vec3 face(int d, const Int3& f) const {
    Vec3 x;
    for (int e = 0; e < 3; ++e) x[e] = e == d ? grid.axis[e].node(f[e]) : grid.axis[e].centre(f[e]);
    return x;
  }
};

inline Body body(std::shared_ptr<const SolidShape> shape, const char* name = "wall") {
  return {name, std::move(shape), false};
}
template <class S, class... A>
Body body_of(A&&... a) {
  return body(std::make_shared<S>(std::forward<A>(a)...));
}
inline Body mesh(std::vector<Triangle> triangles, const char* name = "mesh") {
  return body(std::make_shared<TriangleSet>(std::move(triangles)), name);
}

inline void add_quad(std::vector<Triangle>& list, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  list.push_back({a, b, c}), list.push_back({a, c, d});
}
/// Twelve triangles; every other one is turned round if asked for.
inline std::vector<Triangle> box_mesh(const Vec3& lo, const Vec3& hi, bool mixed = false) {
  std::vector<Triangle> list;
  for (int d = 0; d < 3; ++d)
    for (int up = 0; up < 2; ++up) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      Vec3 q[4];
      for (int c = 0; c < 4; ++c) {
        q[c][d] = up ? hi[d] : lo[d];
        q[c][e] = c == 1 || c == 2 ? hi[e] : lo[e], q[c][f] = c >= 2 ? hi[f] : lo[f];
      }
      add_quad(list, q[0], q[1], q[2], q[3]);
    }
  if (mixed)
    for (std::size_t t = 0; t < list.size(); t += 2) std::swap(list[t][0], list[t][1]);
  return list;
}
/// A tube along d from lo to hi with n facets and so many rings of them, its ends open or closed.
inline std::vector<Triangle> tube_mesh(int d, const Vec3& centre, double radius, double lo, double hi, int n,
                                       bool closed = false, int rings = 1) {
  std::vector<Triangle> list;
  const int e = (d + 1) % 3, f = (d + 2) % 3;
  const auto point = [&](int q, double z) {
    Vec3 x;
    x[d] = z;
    x[e] = centre[e] + radius * std::cos(2 * kPi * (q % n) / n);
    x[f] = centre[f] + radius * std::sin(2 * kPi * (q % n) / n);
    return x;
  };
  for (int q = 0; q < n; ++q) {
    for (int r = 0; r < rings; ++r) {
      const double a = lo + (hi - lo) * r / rings, b = r + 1 < rings ? lo + (hi - lo) * (r + 1) / rings : hi;
      add_quad(list, point(q, a), point(q + 1, a), point(q + 1, b), point(q, b));
    }
    if (!closed) continue;
    for (double z : {lo, hi}) {
      Vec3 middle = centre;
      middle[d] = z;
      list.push_back({middle, point(q, z), point(q + 1, z)});
    }
  }
  return list;
}

inline std::array<std::vector<double>, 3> nodes_of(const Int3& n, const Vec3& lo = {0, 0, 0},
                                                   const Vec3& hi = {1, 1, 1}) {
  std::array<std::vector<double>, 3> nodes;
  for (int d = 0; d < 3; ++d) nodes[d] = graded_nodes(lo[d], hi[d], n[d]);
  return nodes;
}

}  // namespace twogrid
