// What an interval leaves to the next, and what a checked one leaves behind. Entries are found by walking the state's own list, so that one added later is
// looked at too. Without this test a check could change what comes after it, as it once did: it forgot how many steps
// could have been longer, and the fluid's step grew later than without checks.
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <string>
#include <type_traits>

#include "tests/field_exchange.h"
#include "tests/verification/cfd_box.h"

using namespace twogrid;

namespace {

constexpr double kPi = 3.14159265358979323846;

template <class T>
void append(std::string& bits, const T* data, std::size_t n) {
  bits.append(reinterpret_cast<const char*>(data), n * sizeof(T));
}

/// Bits of every entry, by name, and of the last interval's means.
std::map<std::string, std::string> bits(const FluidState& state) {
  std::map<std::string, std::string> all;
  for (int d = 0; d < 3; ++d) {
    const auto& u = state.one_step ? state.u[d] : state.mean_u[d];
    append(all["mean of u"], u.data(), u.size());
    append(all["mean of grad p"], state.mean_grad_p[d].data(), state.mean_grad_p[d].size());
  }
  FluidState::for_each_entry(state, [&](const char* name, const auto& entry) {
    if constexpr (std::is_arithmetic_v<std::decay_t<decltype(entry)>>)
      all[name] = std::string(reinterpret_cast<const char*>(&entry), sizeof entry);
    else
      all[name] = std::string(reinterpret_cast<const char*>(entry.data()), entry.size() * sizeof(double));
  });
  return all;
}

/// Decaying vortices that a drag and a flow rate push along, in a void fraction that changes: steps that shorten the
/// interval, and grow as the flow slows down.
struct Decay {
  CfdBox box;
  FieldExchange exchange;
  double time = 0;

  static FluidSettings settings(Convection scheme, Choice implicit = Choice::kAuto) {
    FluidSettings s;
    s.density = 1.2, s.viscosity = 0.012, s.initial_vortex = 1, s.convection = scheme;
    s.flow_rate_set[0] = true, s.flow_rate[0] = 0.05, s.initial_velocity = {0.1, 0, 0};
    s.implicit_viscosity = implicit;
    return s;
  }
  Decay(Convection scheme, bool keeps_gradient, Choice implicit = Choice::kAuto)
      : box({uniform(0, 1, 16), uniform(0, 1, 16), uniform(0, 0.1, 1)}, {true, true, true},
            settings(scheme, implicit)) {
    if (keeps_gradient) box.fluid->keep_pressure_gradient();
    exchange.beta = box.face_field();
    for (auto& c : exchange.beta) c.fill(0.3);
  }
  FluidReport advance(bool check) {
    const double interval = 0.1;
    VoidFractionInTime path;
    path.begin = &box.eps_begin, path.end = &box.eps_end;
    time += interval;
    const double t = time;
    box.set(box.eps_end, [t](double x, double y, double) {
      return 0.7 + 0.1 * std::sin(2 * kPi * (x - 0.1 * t)) * std::cos(2 * kPi * y);
    });
    const FluidReport r =
        check ? box.fluid->advance_and_check(interval, path, exchange) : box.fluid->advance(interval, path, exchange);
    box.eps_begin = box.eps_end;
    return r;
  }
};

}  // namespace

TEST(FluidState, IsTheSameAfterACheckedInterval) {
  for (Convection scheme : {Convection::kVanLeer, Convection::kCentral})
    for (bool keeps_gradient : {false, true}) {
      Decay plain(scheme, keeps_gradient), watched(scheme, keeps_gradient);
      int most = 0, least = 1000, idle = 0, checks = 0;
      double step_error = 0;
      for (int k = 0; k < 40; ++k) {
        const bool check = k % 5 == 3;
        checks += check;
        const FluidReport a = plain.advance(false), b = watched.advance(check);
        EXPECT_EQ(a.steps, b.steps) << "interval " << k;
        if (check) step_error = std::max(step_error, b.step_error);
        most = std::max(most, a.steps), least = std::min(least, a.steps);
        idle = std::max(idle, plain.box.fluid->state().idle_steps);
        const auto one = bits(plain.box.fluid->state()), other = bits(watched.box.fluid->state());
        ASSERT_EQ(one.size(), other.size());
        for (const auto& [name, value] : one) EXPECT_TRUE(value == other.at(name)) << name << ", interval " << k;
        if (::testing::Test::HasFailure()) return;
      }
      report(
          "checked intervals, %s, gradient %s: %d to %d steps each, up to %d in a row that could be longer, largest "
          "step error %.1e\n",
          scheme == Convection::kCentral ? "central" : "van Leer", keeps_gradient ? "kept" : "not kept", most, least,
          idle, step_error);
      // Steps that could have been longer were counted over intervals that were checked, and the step grew.
      EXPECT_LT(least, most);
      EXPECT_GT(idle, 5);
      EXPECT_GT(step_error, 1e-7);
    }
}

// What a state lacks lives on in the solver that made it: another one then goes on with other bits.
TEST(FluidState, GoesOnInAnotherSolverWithEveryBit) {
  for (Convection scheme : {Convection::kVanLeer, Convection::kCentral})
    for (Choice implicit : {Choice::kOff, Choice::kOn}) {
      Decay one(scheme, true, implicit), other(scheme, true, implicit);
      for (int k = 0; k < 5; ++k) one.advance(false);
      other.box.fluid->state_to_restore() = one.box.fluid->state();
      other.box.fluid->restored();
      other.box.eps_begin = one.box.eps_begin, other.time = one.time;
      for (int k = 0; k < 5; ++k) {
        one.advance(false), other.advance(false);
        const auto a = bits(one.box.fluid->state()), b = bits(other.box.fluid->state());
        ASSERT_EQ(a.size(), b.size());
        for (const auto& [name, value] : a)
          EXPECT_TRUE(value == b.at(name)) << name << ", interval " << k << ", convection " << int(scheme)
                                           << ", implicit " << (implicit == Choice::kOn);
        if (::testing::Test::HasFailure()) return;
      }
    }
}

namespace {

/// A fluid that sets: its viscosity grows with time, and is least where it flows.
struct Setting : FluidModel {
  void properties(const FluidDomain& domain, const FluidState& state, const FaceField<FineGrid>& u,
                  FluidProperties& properties) override {
    auto& mu = properties.viscosity.vary(domain.local);
    for_each(domain.own, [&](int i, int j, int k) {
      mu(i, j, k) = 0.01 * std::exp(4 * state.time) / (1 + std::abs(u[0](i, j, k)) + std::abs(u[1](i, j, k)));
    });
  }
};

/// A scalar by which nothing goes but itself.
struct Ageing : FluidModel {
  void step(const FluidDomain&, const Step& step, FluidState& state) override {
    for (std::size_t m = 0; m < state.fields[0].values.size(); ++m) state.fields[0].values.data()[m] += step.dt;
  }
};

/// A box like Decay's, in which a scene may be a closed one or have models.
struct Scene {
  enum Kind { kFlowRate, kCentral, kSetting, kBodies, kKinds };
  CfdBox box;
  FieldExchange exchange;
  double time = 0;

  static FluidSettings settings(int kind) {
    FluidSettings s;
    s.density = 1.2, s.viscosity = 0.012, s.initial_vortex = 1, s.initial_velocity = {0.1, 0.07, 0.05};
    if (kind == kFlowRate) s.flow_rate_set = {true, true, true}, s.flow_rate = {0.05, 0.03, -0.02};
    if (kind == kSetting) s.implicit_viscosity = Choice::kOff;
    if (kind == kCentral) s.convection = Convection::kCentral, s.implicit_viscosity = Choice::kOn;
    if (kind == kBodies)
      s.open_space = [](const FineGrid&, OpenSpace& space) {
        const auto closed = [](int i, int j) { return i >= 4 && i < 6 && j >= 3 && j < 5; };
        for_each(space.theta.box(), [&](int i, int j, int k) {
          space.theta(i, j, k) = closed(i, j) ? 0 : i == 2 ? 0.7 : 1;
        });
        for (int d = 0; d < 3; ++d)
          for_each(space.alpha[d].box(), [&](int i, int j, int k) {
            space.alpha[d](i, j, k) = closed(i, j) || closed(i - (d == 0), j - (d == 1)) ? 0 : 1;
          });
      };
    return s;
  }
  explicit Scene(int kind)
      : box({uniform(0, 1, 8), uniform(0, 1, 8), uniform(0, 1, 4)}, {true, true, true}, settings(kind)) {
    exchange.beta = box.face_field();
    for (auto& c : exchange.beta) c.fill(0.3);
    if (kind == kSetting) box.fluid->add_model(std::make_unique<Setting>());
    if (kind == kCentral) box.fluid->add_field("age", "s", 0), box.fluid->add_model(std::make_unique<Ageing>());
  }
  /// changed: commands have changed eps since the last interval.
  FluidReport advance(bool changed = false) {
    const double interval = 0.1;
    if (changed)
      for (std::size_t m = 0; m < box.eps_begin.size(); ++m) box.eps_begin.data()[m] -= 0.02 * (m % 3);
    exchange.replaced = exchange.same_flux = changed;
    VoidFractionInTime path;
    path.begin = &box.eps_begin, path.end = &box.eps_end;
    time += interval;
    box.set(box.eps_end, [t = time](double x, double y, double z) {
      return 0.7 + 0.1 * std::sin(2 * kPi * (x - 0.1 * t + z)) * std::cos(2 * kPi * y) + 0.01 * t;
    });
    const FluidReport r = box.fluid->advance(interval, path, exchange);
    box.eps_begin = box.eps_end;
    return r;
  }
  /// What others can ask for now, of own cells and faces.
  void tell(std::string& bits) const {
    const FluidSolver& f = *box.fluid;
    const double t = f.time();
    append(bits, &t, 1);
    for (int d = 0; d < 3; ++d)
      for_each(box.faces(d), [&](int i, int j, int k) {
        const double x[2] = {f.velocity()[d](i, j, k), f.flux(d, i, j, k)};
        append(bits, x, 2);
      });
    for_each(box.own(), [&](int i, int j, int k) {
      const double x[3] = {f.pressure()(i, j, k), f.void_fraction()(i, j, k), f.void_fraction_rate(i, j, k)};
      append(bits, x, 3);
      for (const ModelField& m : f.model_fields()) append(bits, &m.values.data()[m.values.index(i, j, k)], 1);
    });
  }
  /// The course from now on.
  std::string course(int intervals, bool changed) {
    std::string out;
    tell(out);
    for (int n = 0; n < intervals; ++n) {
      const FluidReport r = advance(changed && n == 0);
      const double x[] = {r.dt, r.cfl, r.divergence_error, r.pressure_drop, r.inflow, r.displaced};
      append(out, &r.steps, 1), append(out, &r.pressure_iterations, 1), append(out, x, 6);
      tell(out);
    }
    return out;
  }
};

}  // namespace

// What is no state must not be among the entries, and what is must be read: for each entry there is a flow that goes on
// as another one where that entry alone is left as a new solver has it.
TEST(FluidState, HasNoIdleEntry) {
  if (ranks_of(MPI_COMM_WORLD) > 1) GTEST_SKIP() << "nothing of it hangs on the ranks";
  std::map<std::string, int> matters;
  for (int kind = 0; kind < Scene::kKinds; ++kind)
    for (int stop : {5, 7, 8, 9}) {
      Scene whole(kind);
      for (int n = 0; n < stop; ++n) whole.advance();
      const FluidState state = whole.box.fluid->state();
      const auto go_on = [&](const std::string& but) {
        Scene other(kind);
        std::map<std::string, Array3<double>> arrays;
        std::map<std::string, double> numbers;
        FluidState::for_each_entry(other.box.fluid->state(), [&](const std::string& name, const auto& entry) {
          if constexpr (std::is_arithmetic_v<std::decay_t<decltype(entry)>>)
            numbers[name] = double(entry);
          else
            arrays[name] = entry;
        });
        other.box.fluid->state_to_restore() = state;
        FluidState::for_each_entry(other.box.fluid->state_to_restore(), [&](const std::string& name, auto& entry) {
          using T = std::decay_t<decltype(entry)>;
          if (name != but) return;
          if constexpr (std::is_arithmetic_v<T>)
            entry = T(numbers.at(name));
          else if (arrays.at(name).size() == entry.size())
            static_cast<Array3<double>&>(entry) = arrays.at(name);
          else
            entry.fill(0);
        });
        other.box.fluid->restored();
        other.box.eps_begin = whole.box.eps_begin, other.time = whole.time;
        return other.course(12, stop == 7);
      };
      const std::string right = go_on("");
      FluidState::for_each_entry(state, [&](const std::string& name, const auto& entry) {
        if constexpr (!std::is_arithmetic_v<std::decay_t<decltype(entry)>>)
          if (whole.box.sum(double(entry.size())) == 0) return;
        int& known = matters[name];
        if (known) return;
        int differs = 0;
        try {
          differs = go_on(name) != right;
        } catch (const std::exception&) {  // it can't go on
          differs = 1;
        }
        MPI_Allreduce(MPI_IN_PLACE, &differs, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
        known = differs;
      });
    }
  EXPECT_GE(matters.size(), 30u);
  for (const auto& [name, yes] : matters) EXPECT_TRUE(yes) << name << " makes no difference";
}
