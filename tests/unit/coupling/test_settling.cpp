// The coupling in time, against fluids without space: a fluid that moves as one body has a known answer.
//
// Without these tests a coupling would pass that conserves everything and yet diverges: with the fluid velocity frozen
// over an interval of some response times of the particles, homogeneous settling is amplified from interval to interval
// (formulation A already at a tenth of the response time), and light particles diverge by their added mass at any step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "cfd/parallel/ranks.h"
#include "coupling/coupling.h"
#include "coupling/methods.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// A periodic box of particles on a cubic lattice (overlapping: there are no contacts) with a fluid that moves as one
/// body. eps = 0.4, Stokes' law, so that tau = rho_p eps_s/beta = rho_p d^2/(18 mu).
struct OneBody {
  static constexpr double kEps = 0.4, kSolid = 0.6, kRhoF = 1.0, kTau = 1.0, kGravity = -1.0;

  OneBody(MPI_Comm comm, double rho_p, double k, Formulation form, int dem_steps)
      : comm(comm), rho_p(rho_p), steps(dem_steps), interval(k * kTau), dt(interval / dem_steps) {
    const double h = 1.0;  // node
    const double spacing = h, d = std::cbrt(kSolid * 6 / kPi) * spacing;
    const double mu = rho_p * d * d / (18 * kTau);
    const Int3 n{4, 4, 4};
    const FineGrid grid = make_grid({0, 0, 0}, {2 * h, 2 * h, 2 * h}, n, {true, true, true});
    const Layout layout = make_layout(grid, ranks_of(comm), {2, 2, 2});
    fluid = std::make_unique<FakeFluid>(comm, grid, layout, kRhoF, mu);
    Bodies all;
    for (int k3 = 0; k3 < 2; ++k3)
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i)
          all.add({spacing * (i + 0.3), spacing * (j + 0.4), spacing * (k3 + 0.7)}, 0.5 * d, rho_p, {0, 0, 0},
                  int(all.x.size()) + 1);
    bodies = share_of(all, grid, comm);
    Settings s;
    s.id = "gas";
    s.ratio = {2, 2, 2};
    s.fine = n;
    s.drag = "stokes";
    s.formulation = form;
    s.eps_min = 0.2;
    s.every = dem_steps;
    choose(*find_method("paper"), 0, s);  // eight bodies, one in each node
    settings = s;
    volume = 8 * h * h * h;
  }

  void begin() {
    const ParticleRegion r = make_region(fluid->grid(), comm, 0.1);
    coupling = std::make_unique<Coupling>(comm, settings, *fluid, r.lo, r.hi, r.reach);
    Particles p = bodies.view();
    coupling->start(p, dt);
    gravity(p);
    coupling->force(p, dt, false);
  }
  void gravity(Particles& p) {
    for (int i = 0; i < p.n; ++i) p.f[i][0] = p.f[i][1] = 0, p.f[i][2] = p.mass[i] * (1 - kRhoF / rho_p) * g;
  }
  /// One interval of velocity Verlet; the coupling comes in its last step.
  void run_interval() {
    Particles p = bodies.view();
    for (int s = 1; s <= steps; ++s) {
      for (int i = 0; i < p.n; ++i)
        for (int d = 0; d < 3; ++d) {
          p.v[i][d] += 0.5 * dt * p.f[i][d] / p.mass[i];
          p.x[i][d] += dt * p.v[i][d];
          path[d] += dt * p.v[i][d] * p.mass[i];
        }
      wrap(p);
      if (s == steps) coupling->advance(p, steps, dt);
      gravity(p);
      coupling->force(p, dt, true);
      for (int i = 0; i < p.n; ++i)
        for (int d = 0; d < 3; ++d) p.v[i][d] += 0.5 * dt * p.f[i][d] / p.mass[i];
      if (s == steps) pending = momentum_pending(p);
      coupling->finish_step(p);
    }
  }
  /// What the last half kick gave and the fluid hasn't been charged yet.
  double momentum_pending(const Particles& p) {
    double sum = 0;
    for (int i = 0; i < p.n; ++i) sum += 0.5 * dt * (p.f[i][2] - p.mass[i] * (1 - kRhoF / rho_p) * g);
    return mean(sum);
  }
  /// Particles that leave their rank's brick come back on the opposite side of it: a lattice stays a lattice.
  void wrap(Particles& p) {
    const ParticleRegion r = make_region(fluid->grid(), comm, 0.1);
    for (int i = 0; i < p.n; ++i)
      for (int d = 0; d < 3; ++d) {
        const double l = r.hi[d] - r.lo[d], back = l * std::floor((p.x[i][d] - r.lo[d]) / l);
        p.x[i][d] -= back;
        p.state[i][kPosition + d] -= back;
      }
  }
  double mean(double value) const {
    double all = 0, mine = value;
    MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, comm);
    return all;
  }
  double particle_velocity(int d = 2) {
    double p = 0, m = 0;
    for (std::size_t i = 0; i < bodies.x.size(); ++i) p += bodies.mass[i] * bodies.v[i][d], m += bodies.mass[i];
    return mean(p) / mean(m);
  }
  void set_all(FaceField<FineGrid>& f, double z) {
    fluid->set(f, [&](int d, const Vec3&) { return d == 2 ? z : 0.0; });
  }
  /// Mean of the z component of a reaction over the box.
  double box_mean(const Array3<double>& f) {
    double sum = 0;
    for (std::size_t m = 0; m < f.size(); ++m) sum += f.data()[m];
    return mean(sum) * (volume / 64) / volume;
  }

  MPI_Comm comm;
  double rho_p, g = kGravity;
  int steps;
  double interval, dt, volume = 1;
  std::unique_ptr<FakeFluid> fluid;
  std::unique_ptr<Coupling> coupling;
  Bodies bodies;
  Settings settings;
  double pending = 0;          // see momentum_pending()
  double path[3] = {0, 0, 0};  // sum of m dx, this rank
  double u = 0, u_before = 0, d_before = 0;
  int intervals = 0;
};

/// Steady slip u - v of settling at no net flux: (rho_p - rho_f) eps_s g + beta slip/eps = 0.
double steady_slip(double rho_p) {
  const double beta = rho_p * OneBody::kSolid / OneBody::kTau;
  return -(rho_p - OneBody::kRhoF) * OneBody::kSolid * OneBody::kGravity * OneBody::kEps / beta;
}

/// Closed box: no net volume flux. The fluid follows from continuity, with the velocity of the particles that d(eps)/dt
/// sees (second order backward in time); grad p follows from the fluid's momentum balance.
void close_box(OneBody& s) {
  s.settings.fluid.flow_rate_set[2] = true;
  s.fluid->on_advance = [&s](double D, const VoidFractionInTime&, const Interphase& x) {
    double m = 0;
    for (double q : s.bodies.mass) m += q;
    const double d = s.mean(s.path[2]) / s.mean(m) / D;
    for (double& q : s.path) q = 0;
    const double extrapolated = s.intervals > 0 ? 1.5 * d - 0.5 * s.d_before : d;
    const double un = -(OneBody::kSolid / OneBody::kEps) * extrapolated;
    const double a = s.intervals > 0 ? 1.5 : 1.0, c = a - 1;
    const double inertia = OneBody::kRhoF * OneBody::kEps * (a * (un - s.u) - c * (s.u - s.u_before)) / D;
    const double gradient = s.box_mean(source_of(x, 2, s.fluid->own_faces_[2])) -
                            s.box_mean(made(x.beta_rows, 2, s.fluid->own_faces_[2])) * un - inertia;
    s.d_before = d, s.u_before = s.u, s.u = un, ++s.intervals;
    s.set_all(s.fluid->u_, un);
    s.set_all(s.fluid->mean_, un);
    s.set_all(s.fluid->gradient_, gradient);
  };
}

/// Open box: the mean pressure gradient carries the buoyant weight, the fluid follows from its momentum balance.
void open_box(OneBody& s, bool second_order = true) {
  s.fluid->on_advance = [&s, second_order](double D, const VoidFractionInTime&, const Interphase& x) {
    const double a = second_order && s.intervals > 0 ? 1.5 : 1.0, c = a - 1,
                 inertia = OneBody::kRhoF * OneBody::kEps / D;
    const double gradient = (s.rho_p - OneBody::kRhoF) * OneBody::kSolid * s.g;
    const double un = (inertia * (a * s.u + c * (s.u - s.u_before)) - gradient +
                       s.box_mean(source_of(x, 2, s.fluid->own_faces_[2]))) /
                      (inertia * a + s.box_mean(made(x.beta_rows, 2, s.fluid->own_faces_[2])));
    s.u_before = s.u, s.u = un, ++s.intervals;
    s.set_all(s.fluid->u_, un);
    s.set_all(s.fluid->mean_, un);
    s.set_all(s.fluid->gradient_, gradient);
  };
}

/// Settles from rest for some intervals; checks the slip, its history and the ledger. Returns the final slip.
double settle(MPI_Comm comm, Formulation form, bool closed, double rho_p, double k) {
  OneBody s(comm, rho_p, k, form, k < 1 ? 4 : std::min(100, int(10 * k)));
  if (closed)
    close_box(s);
  else
    open_box(s);
  s.begin();
  const int count = std::clamp(int(30 / k), 12, 1000);
  const double want = steady_slip(rho_p);
  double largest = 0, slip = 0;
  for (int n = 0; n < count; ++n) {
    s.run_interval();
    slip = s.u - s.particle_velocity();
    largest = std::max(largest, std::abs(slip / want));
  }
  const std::string what = std::string(form == Formulation::kA ? "A" : "B") + (closed ? " closed" : " open") +
                           " ratio " + std::to_string(rho_p) + " k " + std::to_string(k);
  EXPECT_NEAR(slip / want, 1, 2e-3) << what;
  EXPECT_LT(largest, 1.2) << what;
  EXPECT_LT(s.coupling->report().momentum_error, 1e-12) << what;
  EXPECT_LT(s.coupling->report().solid_volume_error, 1e-13) << what;
  EXPECT_EQ(s.coupling->report().holding_flux, k > 0.05) << what;
  return slip;
}

// The cases are shared out: each is one rank's, since a body without space has nothing to divide.
TEST(CouplingSettling, StableWithTheRightSlip) {
  int number = 0;
  for (Formulation form : {Formulation::kA, Formulation::kB})
    for (bool closed : {true, false})
      for (double rho_p : {0.8, 2.5, 1000.0})
        for (double k : {0.01, 0.1, 0.5, 1.0, 5.0, 20.0, 100.0})
          if (number++ % ranks_of(MPI_COMM_WORLD) == rank_of(MPI_COMM_WORLD))
            settle(MPI_COMM_SELF, form, closed, rho_p, k);
}

// The held flux is a sum over ranks in every DEM step.
TEST(CouplingSettling, SameOnAllRanksTogether) {
  for (Formulation form : {Formulation::kA, Formulation::kB}) {
    const double together = settle(MPI_COMM_WORLD, form, true, 2.5, 2.0);
    const double alone = settle(MPI_COMM_SELF, form, true, 2.5, 2.0);
    EXPECT_NEAR(together, alone, 1e-12 * std::abs(alone));
  }
}

// Without the implicit part of the reaction (or with a kick that isn't its transpose) the fluid would overshoot by the
// ratio of masses, or momentum would leak.
TEST(CouplingRelaxation, TwoBodiesReachTheirCommonVelocity) {
  for (Formulation form : {Formulation::kA, Formulation::kB})
    for (double rho_p : {0.8, 2.5, 1000.0}) {
      OneBody s(MPI_COMM_WORLD, rho_p, 100.0, form, 400);
      s.g = 0;
      open_box(s, false);
      s.u = s.u_before = 1;
      s.set_all(s.fluid->u_, 1.0);
      s.begin();
      double m = 0;
      for (double q : s.bodies.mass) m += q;
      m = s.mean(m);
      const double fluid_mass = OneBody::kRhoF * OneBody::kEps * s.volume, before = fluid_mass * 1.0;
      const double common = before / (fluid_mass + m);
      s.run_interval();
      // Momentum at the coupling: the half step after it is pending and counted as such.
      const double after = fluid_mass * s.u + m * s.particle_velocity() - s.pending;
      // The particles reach the fluid's first velocity before the coupling corrects them: that sets the scale.
      EXPECT_NEAR(after, before, 1e-12 * m * 1.0) << "ratio " << rho_p;
      EXPECT_NEAR(s.u / common, 1, 1e-6) << "ratio " << rho_p;
      EXPECT_NEAR((s.particle_velocity() - s.pending / m) / common, 1, 1e-6) << "ratio " << rho_p;
      EXPECT_NEAR(s.particle_velocity() / common, 1, 2e-3) << "ratio " << rho_p;
    }
}

}  // namespace
}  // namespace twogrid_test
