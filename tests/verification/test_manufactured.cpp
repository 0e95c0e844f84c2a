// Manufactured solutions. Without these, a term that vanishes in the analytic flows (eps inside the time derivative, in
// the flux, in the stress; d(eps)/dt; the split of the pressure gradient; drag in the projection; ghosts of a side)
// could be wrong or of first order and nothing else would show it. The sources come from the exact fields alone.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>

#include "cfd/parallel/ranks.h"
#include "tests/field_exchange.h"
#include "tests/verification/cfd_box.h"
#include "tests/verification/formulation_a.h"
#include "tests/verification/manufactured.h"

using namespace twogrid;

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double k2Pi = 2 * kPi;

enum class Sides { kPeriodic, kNoSlip, kThrough };
enum class Bed { kStill, kMoving };

/// Box of size 1 x 1, periodic. eps = 0.6 + 0.2 sin(2 pi (x - c t)) cos(2 pi y) is carried with speed c along x.
template <int moving>
ExactFields periodic(const std::array<Taylor, 4>& q) {
  constexpr double c = moving ? 0.5 : 0.0;
  const Taylor x = k2Pi * (q[0] - c * q[3]), y = k2Pi * q[1], t = q[3];
  ExactFields e;
  e.eps = 0.6 + 0.2 * sin(x) * cos(y);
  // psi = (1 + sin(2 t)/2) sin(X) sin(Y) / (2 pi), X = 2 pi x + t
  const Taylor a = 1 + 0.5 * sin(2 * t), X = k2Pi * q[0] + t, Y = y + 0.3;
  e.flux[0] = c * e.eps + a * sin(X) * cos(Y);
  e.flux[1] = 0.2 - a * cos(X) * sin(Y);
  e.p = cos(X) * sin(y + t) + 0.5 * sin(k2Pi * q[0]) * cos(3 * t);
  return e;
}

/// No-slip walls at y = 0 and 1, periodic in x: flux (both components) zero there.
template <int moving>
ExactFields no_slip(const std::array<Taylor, 4>& q) {
  constexpr double w = moving ? 3.0 : 0.0;
  const Taylor x = k2Pi * q[0] - w * q[3], y = q[1], t = q[3];
  const Taylor s = sin(kPi * y), g = s * s, dg = kPi * sin(k2Pi * y);
  ExactFields e;
  constexpr double a = 0.05;
  e.eps = 0.6 + a * cos(x) * dg;
  // psi = g (1 + sin(2 pi x + t)/2) (1 + sin(2 t)/2) / pi; d(eps)/dt is fed by the flux along y.
  const Taylor f = (1 / kPi) * (1 + 0.5 * sin(2 * t)), X = k2Pi * q[0] + t;
  e.flux[0] = dg * (1 + 0.5 * sin(X)) * f;
  e.flux[1] = -a * w * sin(x) * g - kPi * g * cos(X) * f;
  e.p = cos(X) * sin(2 * y + t) + 0.5 * sin(k2Pi * q[0]) * cos(3 * t) * y;
  return e;
}

/// Inlet at x = 0 (eps = 1, flux 1 + sin(t)/2, no tangential velocity), outlet at x = 1 (p = 0.7, no normal gradient
/// of u), periodic in y.
template <int moving>
ExactFields through(const std::array<Taylor, 4>& q) {
  constexpr double w = moving ? 3.0 : 0.0;
  const Taylor x = q[0], y = k2Pi * q[1] - w * q[3], t = q[3];
  const Taylor s = sin(0.5 * kPi * x), h = s * s;
  ExactFields e;
  e.eps = 1 - h * (0.3 + 0.2 * cos(y));
  // m' = x (1 - x)^2: psi = m(x) sin(2 pi y + t) makes a flux without normal gradient at both sides.
  const Taylor m = x * x * (0.5 - x * (2.0 / 3 - 0.25 * x)), dm = x * (1 - x) * (1 - x), Y = k2Pi * q[1] + t;
  e.flux[0] = 1 + 0.5 * sin(t) + k2Pi * m * cos(Y);
  e.flux[1] = (-0.2 * w / k2Pi) * h * cos(y) - dm * sin(Y);
  e.p = 0.7 + (1 - x) * (cos(Y) + 0.5 * cos(3 * t)) + 0.3 * sin(kPi * x) * sin(Y);
  return e;
}

/// Three-dimensional, periodic: eps carried along z, flux c eps z + curl of a vector potential.
ExactFields periodic_3d(const std::array<Taylor, 4>& q) {
  constexpr double c = 0.5;
  const Taylor x = k2Pi * q[0], y = k2Pi * q[1], z = k2Pi * (q[2] - c * q[3]), t = q[3];
  ExactFields e;
  e.eps = 0.6 + 0.2 * sin(x) * cos(y) * sin(z);
  // ABC flow with a phase in time
  e.flux[0] = 0.7 * sin(k2Pi * q[2] + t) + 0.5 * cos(y);
  e.flux[1] = 0.6 * sin(x + t) + 0.7 * cos(k2Pi * q[2]);
  e.flux[2] = c * e.eps + 0.5 * sin(y + t) + 0.6 * cos(x);
  e.p = cos(x + t) * sin(y) * cos(k2Pi * q[2]);
  return e;
}

struct Case {
  Sides sides = Sides::kPeriodic;
  Bed bed = Bed::kMoving;
  bool formulation_a = true;
  double stretch = 1;  // ratio of neighbouring widths on 16 cells
  bool implicit = false;
  bool deep = false;  // three-dimensional
  double beta = 0;    // kg/(m3 s)
  double viscosity = 0.01;
  int more_steps = 1;  // formulation A: times as many
  int turn = 0;        // the solution's x is the solver's direction `turn`
};

constexpr double kDensity = 1.3, kDuration = 0.2;

/// dt proportional to h; Courant number below 0.5 on the smallest cells. In formulation A, whose pressure force is that of
/// the interval before, proportional to h2.
int steps_of(const Case& c, int n) {
  const int steps = c.stretch > 1 ? 2 * n : n;
  return c.formulation_a ? steps * n / 12 * c.more_steps : steps;
}

Solution solution_of(const Case& c) {
  const bool moving = c.bed == Bed::kMoving;
  if (c.deep) return periodic_3d;
  switch (c.sides) {
    case Sides::kPeriodic:
      return moving ? periodic<1> : periodic<0>;
    case Sides::kNoSlip:
      return moving ? no_slip<1> : no_slip<0>;
    case Sides::kThrough:
      return moving ? through<1> : through<0>;
  }
  return nullptr;
}

struct Errors {
  double u, p;
};

/// What the solution asks for at the end of a step: eps, the force that stands in the momentum equation, and u.
struct Moment {
  CellField<FineGrid> eps;
  FaceField<FineGrid> force, u;
};
/// Of all steps, by the number of cells; worked out when first asked for. The drag is no part of it.
using Moments = std::map<int, std::vector<Moment>>;

Errors run(const Case& c, int n, Moments& all_moments) {
  const Solution solution = solution_of(c);
  FluidSettings s;
  s.density = kDensity;
  s.viscosity = c.viscosity;
  s.convection = Convection::kCentral;
  s.implicit_viscosity = c.implicit ? Choice::kOn : Choice::kOff;
  s.pressure_rtol = 1e-7;
  const double dt = kDuration / steps_of(c, n);
  s.dt = dt;
  // A smooth mapping: the ratio of neighbours goes to one as the grid is refined.
  const double ratio = std::pow(c.stretch, 16.0 / n);
  std::array<int, 3> at_solver{c.turn, (c.turn + 1) % 3, (c.turn + 2) % 3};  // of the solution's x, y, z
  std::array<bool, 3> periodic_axis{true, true, true};
  std::array<std::vector<double>, 3> nodes;
  nodes[at_solver[0]] = graded_nodes(0, 1, n, ratio, true);
  nodes[at_solver[1]] = graded_nodes(0, 1, n, ratio, true);
  nodes[at_solver[2]] = c.deep ? graded_nodes(0, 1, n, ratio, true) : uniform(0, 1.0 / n, 1);
  double now = 0;  // time of the step's end
  if (c.sides == Sides::kNoSlip) {
    const int d = at_solver[1];
    periodic_axis[d] = false;
    s.side[2 * d] = s.side[2 * d + 1] = {condition(BoundaryKind::kNoSlip)};
  }
  if (c.sides == Sides::kThrough) {
    const int d = at_solver[0];
    periodic_axis[d] = false;
    BoundaryCondition inlet = condition(BoundaryKind::kInlet);
    inlet.velocity[d] = 1;
    inlet.velocity_now = [&now, d]() {
      Vec3 U{0, 0, 0};
      U[d] = 1 + 0.5 * std::sin(now);
      return U;
    };
    s.side[2 * d] = {inlet};
    s.side[2 * d + 1] = {condition(BoundaryKind::kPressure, {0, 0, 0}, 0.7)};
  }
  CfdBox box(nodes, periodic_axis, s);
  auto fields = [&](const Vec3& x, double t) {
    return at(solution, {x[at_solver[0]], x[at_solver[1]], x[at_solver[2]]}, t);
  };
  auto component = [&](int d) { return (d - c.turn + 3) % 3; };  // of the solution, of the solver's direction d
  auto u_at = [&](int d, double t) -> Function {
    return [&, d, t](double x, double y, double z) {
      const ExactFields e = fields({x, y, z}, t);
      return e.flux[component(d)].v / e.eps.v;
    };
  };
  auto eps_at = [&](double t) -> Function {
    return [&, t](double x, double y, double z) { return fields({x, y, z}, t).eps.v; };
  };
  auto p_at = [&](double t) -> Function {
    return [&, t](double x, double y, double z) { return fields({x, y, z}, t).p.v; };
  };

  auto u = box.face_field(), old = box.face_field();
  for (int d = 0; d < 3; ++d) box.set_faces(d, u[d], u_at(d, 0)), box.set_faces(d, old[d], u_at(d, -dt));
  CellField<FineGrid> p(box.eps_begin.box()), eps_old(box.eps_begin.box());
  box.set(p, p_at(0));
  box.set(box.eps_begin, eps_at(0));
  box.set(eps_old, eps_at(-dt));
  box.fluid->set_state(0, u, p, box.eps_begin, dt, old, eps_old);

  FieldExchange exchange;  // formulation B
  exchange.source = box.face_field();
  if (c.beta > 0) exchange.beta = box.face_field();
  for (int d = 0; d < 3 && c.beta > 0; ++d) exchange.beta[d].fill(c.beta);
  FormulationA particles(box);
  FaceField<FineGrid> drag = box.face_field();
  std::vector<Moment>& moments = all_moments[n];
  moments.resize(steps_of(c, n) + 1);
  auto moment = [&](int step) -> const Moment& {
    Moment& m = moments[step];
    if (m.eps.size() > 0) return m;
    m.eps = CellField<FineGrid>(box.eps_end.box());
    const auto across = [&](int i, int j, int k) { return c.deep ? 0 : Int3{i, j, k}[at_solver[2]]; };
    for_each(m.eps.box(), [&](int i, int j, int k) {
      if (across(i, j, k) == 0) m.eps(i, j, k) = fields(box.cell(i, j, k), now).eps.v;
    });
    // All layers beyond the one of a thin box are the same.
    for_each(m.eps.box(), [&](int i, int j, int k) {
      Int3 x{i, j, k};
      x[at_solver[2]] -= across(i, j, k);
      m.eps(i, j, k) = m.eps(x[0], x[1], x[2]);
    });
    m.force = box.face_field(), m.u = box.face_field();
    for (int d = 0; d < 3; ++d) {
      const int q = component(d);
      if (q == 2 && !c.deep) continue;
      for_each(box.faces(d), [&](int i, int j, int k) {
        const ExactFields e = fields(box.face(d, i, j, k), now);
        m.force[d](i, j, k) = momentum_residual(e, q, kDensity, c.viscosity, c.formulation_a);
        m.u[d](i, j, k) = e.flux[q].v / e.eps.v;
      });
    }
    return m;
  };
  auto step_to = [&](int step) {
    now = step * dt;
    const Moment& m = moment(step);
    box.eps_end = m.eps;
    for (int d = 0; d < 3; ++d)
      for_each(box.faces(d), [&](int i, int j, int k) {
        drag[d](i, j, k) = c.beta * m.u[d](i, j, k);  // the particles move as the fluid should
        exchange.source[d](i, j, k) = m.force[d](i, j, k) + drag[d](i, j, k);
      });
    if (!c.formulation_a) {
      box.step(dt, exchange);
      return;
    }
    box.step(dt, particles.exchange(exchange.beta, drag, m.force));
    particles.read();
  };
  // The particles' pressure force begins at zero; here at what it is in the exact solution, as nearly as the grid knows.
  for (int k = 0; k < 40 && c.formulation_a; ++k) {
    step_to(1);
    box.fluid->set_state(0, u, p, box.eps_begin, dt, old, eps_old);
  }
  for (int step = 1; step <= steps_of(c, n); ++step) {
    step_to(step);
    box.eps_begin = box.eps_end;
  }
  Errors result{0, 0};
  for (int d = 0; d < 3; ++d) {
    const double e = box.face_error(d, u_at(d, now));
    result.u += e * e;
  }
  result.u = std::sqrt(result.u);
  result.p = box.pressure_error(p_at(now), c.sides != Sides::kThrough);
  return result;
}

void expect_orders(const std::string& name, Case c, double ratio, const std::vector<int>& cells, double p_order,
                   Moments& moments) {
  // beta dt/rho on the finest grid.
  c.beta = ratio * kDensity * steps_of(c, cells.back()) / kDuration;
  std::vector<Errors> e;
  for (int n : cells) e.push_back(run(c, n, moments));
  const std::size_t last = e.size() - 1;
  const double scale = std::log(double(cells[last]) / cells[last - 1]);
  const double u = std::log(e[last - 1].u / e[last].u) / scale, p = std::log(e[last - 1].p / e[last].p) / scale;
  const int rank = rank_of(MPI_COMM_WORLD);
  if (rank == 0) {
    std::printf("%-34s %s %s %s beta dt/rho %6g: u", name.c_str(), c.formulation_a ? "A" : "B",
                c.stretch > 1 ? "stretched" : "uniform  ", c.bed == Bed::kMoving ? "moving" : "still ", ratio);
    for (const auto& x : e) std::printf(" %.2e", x.u);
    std::printf(" order %.2f, p", u);
    for (const auto& x : e) std::printf(" %.2e", x.p);
    std::printf(" order %.2f\n", p);
  }
  EXPECT_GT(u, 1.9) << name;
  EXPECT_GT(p, p_order) << name;
}

const char* name_of(Sides s) {
  return s == Sides::kPeriodic ? "periodic" : s == Sides::kNoSlip ? "no-slip walls" : "inlet and outlet";
}

void all_combinations(Sides sides, double p_order) {
  for (double stretch : {1.0, 1.1})
    for (bool a : {true, false})
      for (Bed bed : {Bed::kStill, Bed::kMoving}) {
        Moments moments;
        for (double ratio : {0.01, 1.0, 100.0}) {
          Case c;
          c.sides = sides, c.bed = bed, c.formulation_a = a, c.stretch = stretch;
          const bool finer = sides == Sides::kThrough && stretch > 1;
          expect_orders(name_of(sides), c, ratio, finer ? std::vector<int>{16, 32} : std::vector<int>{12, 24}, p_order,
                        moments);
        }
      }
}

}  // namespace

TEST(Manufactured, Periodic) {
  all_combinations(Sides::kPeriodic, 1.8);
}

TEST(Manufactured, NoSlipWalls) {
  all_combinations(Sides::kNoSlip, 1.4);
}

TEST(Manufactured, InletAndOutlet) {
  all_combinations(Sides::kThrough, 1.8);
}

TEST(Manufactured, ImplicitViscosity) {
  for (Sides sides : {Sides::kPeriodic, Sides::kNoSlip, Sides::kThrough})
    for (bool a : {true, false}) {
      Case c;
      Moments moments;
      c.sides = sides, c.formulation_a = a, c.implicit = true, c.viscosity = 0.1;
      expect_orders(std::string(name_of(sides)) + ", implicit mu", c, 1.0, {12, 24},
                    sides == Sides::kNoSlip ? 1.4 : 1.8, moments);
    }
}

TEST(Manufactured, FineGridsOtherAxesAndThreeDimensions) {
  for (Sides sides : {Sides::kPeriodic, Sides::kNoSlip, Sides::kThrough}) {
    Case c;
    Moments moments;
    c.sides = sides, c.stretch = 1.15, c.turn = 1 + int(sides) % 2;
    expect_orders(std::string(name_of(sides)) + ", 3 levels", c, 1.0, {12, 24, 48}, sides == Sides::kNoSlip ? 1.4 : 1.8,
                  moments);
  }
  Case c;
  Moments moments;
  c.deep = true;
  expect_orders("periodic 3-D", c, 1.0, {8, 16}, 1.8, moments);
}
