// What a checked interval leaves behind. Entries are found by walking the state's own list, so that one added later is
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

/// Bits of every entry, by name.
std::map<std::string, std::string> bits(const FluidState& state) {
  std::map<std::string, std::string> all;
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
      : box({uniform(0, 1, 16), uniform(0, 1, 16), uniform(0, 0.1, 1)}, {true, true, true}, settings(scheme, implicit)) {
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
