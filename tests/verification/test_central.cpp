// How long a step central convection bears. Inviscid Taylor-Green vortices are a steady solution that central convection
// keeps without any loss: whatever the scheme in time makes grow, grows until the velocity is not finite. Without this
// test a scheme that grows by 0.7 % a step would pass: viscosity, van Leer's limiter or a short run hide it.
#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kSpeed = 0.5;  // amplitude of the vortices; of |u|/h + |v|/h, too: largest of |sin(x + y)|
constexpr int kCells = 32;

FluidSettings inviscid() {
  FluidSettings s;
  s.density = 1.2, s.convection = Convection::kCentral, s.initial_vortex = kSpeed, s.pressure_rtol = 1e-8;
  return s;
}

struct Vortices : CfdBox {
  explicit Vortices(const FluidSettings& s)
      : CfdBox({uniform(0, 1, kCells), uniform(0, 1, kCells), uniform(0, 1.0 / kCells, 1)}, {true, true, true}, s) {}
  double energy() {
    double sum = 0;
    for (int d = 0; d < 2; ++d)
      for_each(faces(d), [&](int i, int j, int k) { sum += std::pow(fluid->velocity()[d](i, j, k), 2); });
    return this->sum(sum);
  }
};

/// Error of u over its amplitude (root mean square) after `steps` equal steps; infinite where it isn't finite.
double error_after(int steps, double courant) {
  FluidSettings s = inviscid();
  const double dt = courant / (kSpeed * kCells);
  s.dt = dt;
  Vortices box(s);
  try {
    for (int k = 0; k < steps; ++k) box.step(dt);
  } catch (const std::runtime_error&) {
    return INFINITY;
  }
  return box.face_error(0, [](double x, double y, double) {
    return kSpeed * std::sin(2 * kPi * x) * std::cos(2 * kPi * y);
  }) / kSpeed;
}

}  // namespace

TEST(Central, EqualStepsUpToTheLargestCfl) {
  // 1000 steps: later the vortices break up by themselves, as inviscid ones must.
  const double largest = FluidSettings::largest_cfl(Convection::kCentral);
  double bound = 0;
  const std::vector<double> tried = ranks_of(MPI_COMM_WORLD) > 1
                                        ? std::vector<double>{largest}
                                        : std::vector<double>{0.2, 0.3, 0.4, 0.5, largest, 0.65, 0.7, 0.75, 0.8};
  for (double courant : tried) {
    const double e = error_after(1000, courant);
    report("inviscid vortices, 1000 steps at a Courant number of %.2f: error %.1e U\n", courant, e);
    if (courant <= largest) {
      EXPECT_LT(e, 1e-3) << courant;
    }
    if (!(e < 1e-3)) break;
    bound = courant;
  }
  report("inviscid vortices: stable up to a Courant number of %.2f (theory 0.67)\n", bound);
}

TEST(Central, EnergyStaysWhenTheFlowChoosesTheStep) {
  // Long enough for the vortices to break up into a flow of all scales, in which speeds change and steps with them.
  for (double cfl : {FluidSettings::largest_cfl(Convection::kCentral), 0.4}) {
    if (cfl == 0.4 && ranks_of(MPI_COMM_WORLD) > 1) break;
    FluidSettings s = inviscid();
    s.cfl = cfl;
    Vortices box(s);
    const double begin = box.energy();
    double most = 0, courant = 0;
    int steps = 0;
    for (int k = 0; k < 40; ++k) {
      const FluidReport r = box.step(2.0);
      steps += r.steps, courant = std::max(courant, r.cfl);
      most = std::max(most, box.energy() / begin);
    }
    const double gone = box.face_error(
        0, [](double x, double y, double) { return kSpeed * std::sin(2 * kPi * x) * std::cos(2 * kPi * y); });
    report(
        "inviscid vortices, cfl %.1f: %d steps, Courant number %.3f at most, change of u %.1f U, energy %.6f of the "
        "beginning's at most, %.6f at the end\n",
        cfl, steps, courant, gone / kSpeed, most, box.energy() / begin);
    EXPECT_LT(most, 1.0001) << cfl;
    EXPECT_LE(courant, cfl * (1 + 1e-9));
  }
}

TEST(Central, LargerCourantNumbersAreRefused) {
  FluidSettings s;
  s.density = 1, s.convection = Convection::kCentral, s.cfl = 0.61;
  const auto nodes = uniform(0, 1, 4);
  EXPECT_THROW(CfdBox({nodes, nodes, nodes}, {true, true, true}, s), std::invalid_argument);
  s.cfl = 0.6;
  CfdBox box({nodes, nodes, nodes}, {true, true, true}, s);
  s.convection = Convection::kVanLeer, s.cfl = 1;
  CfdBox limited({nodes, nodes, nodes}, {true, true, true}, s);
}
