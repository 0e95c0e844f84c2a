// The state of the coupling is whole, and nothing in it is idle. A run is stopped between couplings; a second coupling,
// made anew, is given copies of its state, its particles and its fluid, and goes on: every bit is the same. And for each
// entry of the state's list there is a run that ends otherwise if that entry alone has another value. Without this test
// a part of what an interval leaves to the next could live outside of the list: a checkpoint that is made of it would
// then begin another run, as one without the largest drag number of the last coupling would have.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <type_traits>

#include "coupling/coupling.h"
#include "coupling/coupling_state.h"
#include "coupling/methods.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

constexpr double kDensity = 1.0, kStep = 1e-3, kOtherStep = 0.5e-3;
constexpr int kEvery = 4;

struct Scene {
  explicit Scene(const Settings& s, double viscosity)
      : grid(make_grid({0, 0, 0}, {1, 1, 1}, {8, 8, 8}, {true, true, true})),
        fluid(MPI_COMM_SELF, grid, make_layout(grid, 1, {2, 2, 2}), kDensity, viscosity),
        coupling(MPI_COMM_SELF, s, fluid, {0, 0, 0}, {1, 1, 1}, 0.1) {
    for (FaceField<FineGrid>* f : {&fluid.u_, &fluid.mean_})
      fluid.set(*f, [](int d, const Vec3& x) { return d == 2 ? 1 + 0.3 * std::sin(6.28 * x[0]) : 0.1 * d; });
    fluid.on_advance = [this](double D, const VoidFractionInTime& eps, const Interphase& x) { flow(D, eps, x); };
  }

  /// Every face by itself: inertia, drag, and a push by the void fraction's path; mean of begin and end.
  void flow(double D, const VoidFractionInTime& eps, const Interphase& exchange) {
    for (int d = 0; d < 3; ++d) {
      const Box own = fluid.own_faces_[d];
      const bool reacts = exchange.reacts();
      Array3<double> source(own), beta(own);
      if (reacts) source = source_of(exchange, d, own), beta = made(exchange.beta_rows, d, own);
      const FaceComponent<FineGrid> before = fluid.u_[d];
      for_each(fluid.u_[d].box(), [&](int i, int j, int k) {
        const int a = (i + 8) % 8, b = (j + 8) % 8, c = (k + 8) % 8;
        const double e = eps.at(eps.end->index(a, b, c), 0.3, D), inertia = kDensity / D;
        const double u = before(a, b, c) + 0.1 * D * (1 - e) + (exchange.replaced ? 1e-3 : 0.0);
        const double now = reacts ? (inertia * u + source(a, b, c)) / (inertia + beta(a, b, c)) : u;
        fluid.u_[d](i, j, k) = now;
        fluid.mean_[d](i, j, k) = 0.5 * (now + before(a, b, c));
        fluid.gradient_[d](i, j, k) = 0.2 * now - 0.1 * d;
      });
    }
  }

  Particles view() {
    Particles p = bodies.view();
    for (double& l : p.period) l = 1;
    p.still = still, p.growing = growing;
    return p;
  }
  void gravity(Particles& p) {
    for (int i = 0; i < p.n; ++i) p.f[i][0] = p.f[i][1] = 0, p.f[i][2] = -9.81 * p.mass[i];
  }
  /// Set-up of a run.
  void begin() {
    Particles p = view();
    coupling.start(p, dt);
    gravity(p);
    coupling.force(p, dt, false);
  }
  void rest() {
    Particles p = view();
    coupling.rest(p);
  }
  void run(int steps) {
    for (int n = 0; n < steps; ++n) {
      Particles p = view();
      const bool quiet = still && since + 1 < kEvery;
      if (!still) kick(p), drift(p);
      if (growing)
        for (double& r : bodies.radius) r *= 1.0005;
      time += dt;
      if (++since == kEvery) coupling.advance(p, since, time / since), since = 0, time = 0;
      if (quiet) {
        coupling.repeat_force();
      } else {
        gravity(p);
        coupling.force(p, dt, true);
      }
      if (!still) kick(p);
      coupling.finish_step(p);
    }
  }
  void kick(Particles& p) const {
    for (int i = 0; i < p.n; ++i)
      for (int d = 0; d < 3; ++d) p.v[i][d] += 0.5 * dt * p.f[i][d] / p.mass[i];
  }
  void drift(Particles& p) const {
    for (int i = 0; i < p.n; ++i)
      for (int d = 0; d < 3; ++d) p.x[i][d] += dt * p.v[i][d], p.x[i][d] -= std::floor(p.x[i][d]);
  }
  void remove_last() {
    Bodies less;
    for (std::size_t q = 0; q + 1 < bodies.x.size(); ++q) {
      less.add(bodies.x[q], bodies.radius[q], 1, bodies.v[q], bodies.tag[q]);
      less.f.back() = bodies.f[q], less.mass.back() = bodies.mass[q];
      less.state.back() = bodies.state[q], less.step.back() = bodies.step[q];
    }
    bodies = less;
  }

  FineGrid grid;
  FakeFluid fluid;
  Coupling coupling;
  Bodies bodies;
  double dt = kStep, time = 0;
  int since = 0;
  bool still = false, growing = false;
};

struct Case {
  const char* name;
  Formulation formulation;
  bool two_sizes;
  double viscosity, density;
  std::function<void(Scene&)> before, after;  // the stop
};

Settings settings_of(const Case& c) {
  Settings s;
  s.id = "gas", s.fine = {8, 8, 8}, s.ratio = {2, 2, 2}, s.every = kEvery, s.formulation = c.formulation;
  choose(*find_method(kDefaultMethod), 0, s);
  return s;
}

void fill(Scene& scene, bool two_sizes, double density) {
  for (int q = 0; q < 40; ++q)
    scene.bodies.add(
        {0.5 + 0.49 * std::sin(1.0 + 3 * q), 0.5 + 0.49 * std::cos(2.3 * q), 0.5 + 0.49 * std::sin(0.7 * q)},
        two_sizes && q % 3 == 0 ? 0.05 : 0.08, density, {0.3 * std::sin(q), 0.1, -0.2}, q + 1);
}

std::vector<Case> cases() {
  const auto moves = [](Scene& s) { s.begin(), s.run(3 * kEvery + 2); };
  const auto goes_on = [](Scene& s) { s.run(3 * kEvery); };
  const auto shorter = [](Scene& s) { s.dt = kOtherStep, s.run(2 * kEvery); };
  const auto lies = [](Scene& s) {
    for (auto& v : s.bodies.v) v = {0, 0, 0};
    s.still = true, s.begin(), s.run(2 * kEvery + 2);
  };
  const auto rests = [](Scene& s) { s.begin(), s.run(2 * kEvery + 2), s.rest(); };
  const auto changed = [](Scene& s) { s.remove_last(), s.begin(), s.run(kEvery); };
  return {
      {"weak drag", Formulation::kB, false, 1e-3, 500, moves, goes_on},
      {"strong drag", Formulation::kB, false, 3, 5, moves, goes_on},
      {"strong drag, two sizes", Formulation::kB, true, 3, 5, moves, goes_on},
      {"formulation A", Formulation::kA, false, 0.3, 5, moves, goes_on},
      {"formulation A, weak drag", Formulation::kA, false, 1e-3, 500, moves, goes_on},
      {"another step", Formulation::kB, false, 1e-3, 5, moves, shorter},
      {"still", Formulation::kB, false, 0.1, 5, lies, goes_on},
      {"still, one is deleted", Formulation::kB, false, 0.1, 5, lies, [](Scene& s) { s.remove_last(), s.run(kEvery); }},
      {"comes to lie still", Formulation::kB, false, 0.1, 5, moves, [](Scene& s) { s.still = true, s.run(kEvery); }},
      {"between runs", Formulation::kB, false, 0.1, 5, rests, changed},
      {"after commands", Formulation::kB, false, 0.1, 5, [=](Scene& s) { rests(s), s.remove_last(), s.begin(); },
       goes_on},
      {"grows", Formulation::kB, false, 0.1, 5,
       [](Scene& s) { s.growing = true, s.begin(), s.run(kEvery + 2), s.rest(); },
       [](Scene& s) { s.begin(), s.run(kEvery); }},
  };
}

template <class T>
void append(std::string& bits, const T* data, std::size_t n) {
  bits.append(reinterpret_cast<const char*>(data), n * sizeof(T));
}

/// All that a run has come to.
std::string outcome(Scene& s) {
  std::string bits;
  const Bodies& b = s.bodies;
  const std::size_t n = b.x.size();
  append(bits, b.x.data(), n), append(bits, b.v.data(), n), append(bits, b.f.data(), n);
  append(bits, b.state.data(), n), append(bits, b.step.data(), n);
  for (int d = 0; d < 3; ++d) append(bits, s.fluid.u_[d].data(), s.fluid.u_[d].size());
  const Report& r = s.coupling.report();
  for (double x :
       {r.solid_volume_error, r.momentum_error, r.volume_moved, r.volume_unplaced, r.eps_min, r.max_drag_number,
        r.solid_volume, r.volume_inserted, r.volume_vanished, r.inserted_total, r.vanished_total, r.grown_total,
        double(r.particles), double(r.fluid_steps), r.travel, double(r.holding_flux), double(r.pressure_force)})
    append(bits, &x, 1);
  return bits;
}

/// What one interval hands to the next goes from one scene to another. `other`: in the entry of this name another value
/// is put, of the kind `which`.
void hand_over(Scene& from, Scene& to, const std::string& other, int which) {
  to.bodies = from.bodies;
  to.fluid.u_ = from.fluid.u_, to.fluid.mean_ = from.fluid.mean_, to.fluid.gradient_ = from.fluid.gradient_;
  to.fluid.eps_ = from.fluid.eps_;
  to.dt = from.dt, to.time = from.time, to.since = from.since, to.still = from.still, to.growing = from.growing;
  to.coupling.state() = from.coupling.state();
  CouplingState::for_each_entry(to.coupling.state(), [&](const std::string& name, auto& entry) {
    if (name != other) return;
    using T = std::decay_t<decltype(entry)>;
    if constexpr (std::is_same_v<T, bool>)
      entry = !entry;
    else if constexpr (std::is_integral_v<T>)
      entry += which == 0 ? 1 : -1;
    else if constexpr (std::is_same_v<T, double>)
      entry = which == 0 ? 0x1p14 * entry + 1e-2 : kOtherStep;
    else
      for (std::size_t m = 0; m < entry.size(); ++m) entry.data()[m] = 0.99 * entry.data()[m] + 1e-3;
  });
}

/// Flags that promise a field: set where there is none they would be no state that can come about.
const std::set<std::string> kPromises{"holding", "motion_drag", "change_resting", "change_changed"};

TEST(CouplingState, GoesOnInAnotherCouplingWithEveryBit) {
  for (const Case& c : cases()) {
    Scene one(settings_of(c), c.viscosity), other(settings_of(c), c.viscosity);
    fill(one, c.two_sizes, c.density);
    c.before(one);
    hand_over(one, other, "", 0);
    c.after(one), c.after(other);
    EXPECT_TRUE(outcome(one) == outcome(other)) << c.name;
  }
}

TEST(CouplingState, HasNoIdleEntry) {
  std::map<std::string, bool> matters;
  for (const Case& c : cases()) {
    Scene whole(settings_of(c), c.viscosity);
    fill(whole, c.two_sizes, c.density);
    c.before(whole);
    std::vector<std::string> names;
    CouplingState::for_each_entry(whole.coupling.state(), [&](const std::string& name, const auto& entry) {
      bool promise = false;
      if constexpr (std::is_same_v<std::decay_t<decltype(entry)>, bool>) promise = !entry && kPromises.count(name);
      if (!promise && !matters[name]) names.push_back(name);
    });
    Scene copy(settings_of(c), c.viscosity);
    hand_over(whole, copy, "", 0);
    c.after(copy);
    const std::string right = outcome(copy);
    for (const std::string& name : names)
      for (int which : {0, 1}) {
        Scene scene(settings_of(c), c.viscosity);
        hand_over(whole, scene, name, which);
        bool same = false;
        try {
          c.after(scene);
          same = outcome(scene) == right;
        } catch (const std::exception&) {  // it can't go on at all
        }
        matters[name] = matters[name] || !same;
      }
  }
  EXPECT_GT(matters.size(), 30u);
  for (const auto& [name, yes] : matters) EXPECT_TRUE(yes) << name << " makes no difference";
}

}  // namespace
}  // namespace twogrid_test
