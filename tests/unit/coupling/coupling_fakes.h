// A fluid without equations and particles without contacts: what the tests of the coupling need of either.
#pragma once

#include <mpi.h>

#include <functional>
#include <random>
#include <vector>

#include "cfd/fluid/fluid.h"
#include "cfd/measures/grid_measures.h"
#include "cfd/parallel/block_exchange.h"
#include "cfd/parallel/ranks.h"
#include "coupling/particles/particles.h"
#include "coupling/two_grid/window.h"

namespace twogrid_test {

using namespace twogrid;

/// Bricks a direction for 1, 2, 4 and 8 ranks.
inline Int3 bricks(int ranks) {
  Int3 p{1, 1, 1};
  for (int d = 2; ranks > 1; d = (d + 2) % 3, ranks /= 2) p[d] *= 2;
  return p;
}

inline FineGrid make_grid(const Vec3& lo, const Vec3& hi, const Int3& n, const std::array<bool, 3>& periodic,
                          const Vec3& stretch = {1, 1, 1}) {
  FineGrid g;
  for (int d = 0; d < 3; ++d) g.axis[d] = Axis(graded_nodes(lo[d], hi[d], n[d], stretch[d]), periodic[d]);
  return g;
}

inline Layout make_layout(const FineGrid& grid, int ranks, const Int3& ratio) {
  const Int3 p = bricks(ranks);
  std::array<std::vector<int>, 3> cuts;
  for (int d = 0; d < 3; ++d) cuts[d] = cuts_even(grid.axis[d], p[d], ratio[d]);
  return Layout(grid, cuts);
}

/// Brick of the particle decomposition: equal parts of the box, whatever the grid's layout.
inline ParticleRegion make_region(const FineGrid& grid, MPI_Comm comm, double reach) {
  const Int3 p = bricks(ranks_of(comm));
  const int r = rank_of(comm);
  const Int3 b{r % p[0], (r / p[0]) % p[1], r / (p[0] * p[1])};
  ParticleRegion region;
  for (int d = 0; d < 3; ++d) {
    const double lo = grid.axis[d].lo(), l = grid.axis[d].length();
    region.lo[d] = lo + l * b[d] / p[d];
    region.hi[d] = lo + l * (b[d] + 1) / p[d];
  }
  region.reach = reach;
  return region;
}

class FakeFluid : public Fluid {
 public:
  FakeFluid(MPI_Comm comm, const FineGrid& grid, const Layout& layout, double density = 1, double viscosity = 1)
      : comm_(comm), grid_(grid), layout_(layout), density_(density), viscosity_(viscosity) {
    const int r = rank_of(comm);
    for (int d = 0; d < 3; ++d) {
      const Box own = layout.faces(d, r), box = own.empty() ? own : own.grown(kHalo);
      own_faces_[d] = own;
      for (FaceField<FineGrid>* f : {&u_, &mean_, &gradient_}) (*f)[d].reset(box);
      state_[d].reset(box, FaceState::kSolved);
      // Sides that are not periodic are walls until a test opens them.
      const Axis& a = grid.axis[d];
      for_each(box, [&](int i, int j, int k) {
        const Int3 c{i, j, k};
        if (!a.periodic() && (c[d] <= 0 || c[d] >= a.n())) state_[d](i, j, k) = FaceState::kFixed;
      });
    }
    own_cells_ = layout.cells(r);
    eps_.reset(own_cells_.empty() ? own_cells_ : own_cells_.grown(kHalo), 1.0);
    pressure_.reset(eps_.box());
  }

  const FineGrid& grid() const override { return grid_; }
  const Layout& layout() const override { return layout_; }
  double density() const override { return density_; }
  double viscosity() const override { return viscosity_; }
  const Array3<FaceState>& face_state(int d) const override { return state_[d]; }
  const OpenShares* open_shares() const override { return open_.get(); }
  const FaceField<FineGrid>& velocity() const override { return u_; }
  const FaceField<FineGrid>& mean_velocity() const override { return mean_; }
  const FaceField<FineGrid>& mean_pressure_gradient() const override { return gradient_; }
  const CellField<FineGrid>& pressure() const override { return pressure_; }
  const CellField<FineGrid>& void_fraction() const override { return eps_; }
  double time() const override { return time_; }
  void start(const CellField<FineGrid>& eps) override { eps_ = eps; }
  FluidReport advance(double interval, const VoidFractionInTime& eps, const Interphase& exchange) override {
    eps_ = *eps.end;
    time_ += interval;
    if (on_advance) on_advance(interval, eps, exchange);
    return {};
  }

  /// Sets a face field from a function of direction and position (the face's centre); halo included.
  void set(FaceField<FineGrid>& f, const std::function<double(int, const Vec3&)>& value) {
    for (int d = 0; d < 3; ++d)
      for_each(f[d].box(), [&](int i, int j, int k) {
        const Int3 c{i, j, k};
        Vec3 x;
        for (int e = 0; e < 3; ++e) x[e] = e == d ? grid_.axis[e].node(c[e]) : grid_.axis[e].centre(c[e]);
        f[d](i, j, k) = value(d, x);
      });
  }
  void open_side(int d, bool high) {
    for_each(state_[d].box(), [&](int i, int j, int k) {
      const Int3 c{i, j, k};
      if (c[d] == (high ? grid_.axis[d].n() : 0)) state_[d](i, j, k) = FaceState::kSolved;
    });
  }

  /// Open shares from functions of position, closed faces fixed; face: of direction and the face's centre.
  void cut(const std::function<double(int, const Vec3&)>& alpha_at,
           const std::function<double(const Vec3&)>& theta_at) {
    const Box& local = eps_.box();
    const GridMeasures measures(grid_, own_cells_, local);
    OpenShares::Held held;
    FaceField<FineGrid>&alpha = held.alpha, &theta_f = held.theta_f;
    CellField<FineGrid>& theta = held.theta;
    theta.reset(local, 1.0);
    const auto inside = [&](Vec3 x) {
      for (int d = 0; d < 3; ++d) {
        const Axis& a = grid_.axis[d];
        if (a.periodic()) x[d] -= a.length() * std::floor((x[d] - a.lo()) / a.length() + 1e-9);
      }
      return x;
    };
    double open = 0;
    for_each(local, [&](int i, int j, int k) {
      theta(i, j, k) = theta_at(inside({grid_.axis[0].centre(i), grid_.axis[1].centre(j), grid_.axis[2].centre(k)}));
    });
    for_each(own_cells_, [&](int i, int j, int k) { open += theta(i, j, k) * grid_.volume(i, j, k); });
    MPI_Allreduce(MPI_IN_PLACE, &open, 1, MPI_DOUBLE, MPI_SUM, comm_);
    for (int d = 0; d < 3; ++d) alpha[d].reset(local, 1.0), theta_f[d].reset(local, 1.0);
    set(alpha, [&](int d, const Vec3& x) { return alpha_at(d, inside(x)); });
    measures.face_mean(theta, theta_f);
    for (int d = 0; d < 3; ++d)
      for_each(intersect(state_[d].box(), local), [&](int i, int j, int k) {
        if (!(alpha[d](i, j, k) > 0)) state_[d](i, j, k) = FaceState::kFixed;
      });
    held.volume = open;
    open_ = std::make_unique<OpenShares>(measures, local, own_cells_,
                                         std::array<Box, 3>{own_cells_, own_cells_, own_cells_},
                                         std::array<bool, 3>{true, true, true}, std::move(held));
  }

  std::unique_ptr<OpenShares> open_;
  FaceField<FineGrid> u_, mean_, gradient_;
  CellField<FineGrid> eps_, pressure_;
  std::array<Array3<FaceState>, 3> state_;
  std::array<Box, 3> own_faces_;
  Box own_cells_;
  std::function<void(double, const VoidFractionInTime&, const Interphase&)> on_advance;

 private:
  MPI_Comm comm_;
  FineGrid grid_;
  Layout layout_;
  double density_, viscosity_, time_ = 0;
};

/// Shares of a body that closes a corner of the box and cuts the cells around it.
inline double body_theta(const Vec3& x) {
  return std::min(1.0, std::max(0.0, 4 * (x[0] + 0.6 * x[1] + 0.2 * x[2] - 0.35)));
}
inline double body_alpha(const FineGrid& grid, int d, const Vec3& x) {
  const Axis& a = grid.axis[d];
  int f = 0;
  while (f < a.n() && std::abs(a.node(f) - x[d]) > 1e-6) ++f;
  double least = 1;
  for (int c : {f - 1, f}) {
    if (!a.periodic()) c = std::min(std::max(c, 0), a.n() - 1);
    Vec3 cell = x;
    cell[d] = a.centre(a.periodic() ? (c + a.n()) % a.n() : c);
    least = std::min(least, body_theta(cell));
  }
  return least > 0.05 ? 0.3 + 0.7 * least : 0.0;
}
inline void cut_corner(FakeFluid& fluid) {
  fluid.cut([&](int d, const Vec3& x) { return body_alpha(fluid.grid(), d, x); }, body_theta);
}

/// Rows of an exchange as a field of one direction.
inline Array3<double> made(const FaceRows* rows, int d, const Box& faces) {
  Array3<double> f(faces);
  for (int k = faces.lo[2]; k < faces.hi[2]; ++k)
    for (int j = faces.lo[1]; j < faces.hi[1]; ++j)
      rows->row(d, faces.lo[0], j, k, faces.size(0), &f.data()[f.index(faces.lo[0], j, k)]);
  return f;
}
/// Source of an exchange, held or made.
inline Array3<double> source_of(const Interphase& x, int d, const Box& faces) {
  if (x.source[d].size() == 0) return made(x.source_rows, d, faces);
  return x.source[d];
}

/// Particles that a test owns.
struct Bodies {
  std::vector<std::array<double, 3>> x, v, f;
  std::vector<double> radius, mass;
  std::vector<int> tag;
  std::vector<std::array<double, kParticleColumns>> state;
  std::vector<std::array<double, kStepColumns>> step;
  std::vector<double*> rows, step_rows;

  void add(const Vec3& at, double r, double density, const Vec3& velocity = {0, 0, 0}, int id = 0) {
    x.push_back(at);
    v.push_back(velocity);
    f.push_back({0, 0, 0});
    radius.push_back(r);
    mass.push_back(density * 4.18879020478639098462 * r * r * r);
    tag.push_back(id);
    state.push_back({});
    step.push_back({});
  }
  Particles view() {
    rows.clear(), step_rows.clear();
    for (auto& s : state) rows.push_back(s.data());
    for (auto& s : step) step_rows.push_back(s.data());
    Particles p;
    p.n = int(x.size());
    p.x = reinterpret_cast<double(*)[3]>(x.data());
    p.v = reinterpret_cast<double(*)[3]>(v.data());
    p.f = reinterpret_cast<double(*)[3]>(f.data());
    p.radius = radius.data();
    p.mass = mass.data();
    p.tag = tag.data();
    p.state = rows.data();
    p.step = step_rows.data();
    return p;
  }
};

/// The bodies that lie in this rank's brick; those outside the domain go to the brick nearest to them.
inline Bodies share_of(const Bodies& all, const FineGrid& grid, MPI_Comm comm) {
  const Int3 p = bricks(ranks_of(comm));
  Bodies mine;
  for (std::size_t q = 0; q < all.x.size(); ++q) {
    Int3 b;
    for (int d = 0; d < 3; ++d) {
      const double s = (all.x[q][d] - grid.axis[d].lo()) / grid.axis[d].length();
      b[d] = std::min(std::max(int(std::floor(s * p[d])), 0), p[d] - 1);
    }
    if (b[0] + p[0] * (b[1] + p[1] * b[2]) != rank_of(comm)) continue;
    mine.add(all.x[q], all.radius[q], all.mass[q] / (4.18879020478639098462 * std::pow(all.radius[q], 3)), all.v[q],
             all.tag[q]);
    mine.mass.back() = all.mass[q];
  }
  return mine;
}

}  // namespace twogrid_test
