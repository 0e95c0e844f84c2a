// Particles are inserted everywhere at once into fluid that flows evenly: the fluid that is left flows on as it did, or,
// where the flux is to be kept, faster by the ratio of the void fractions, and stays so; no pressure arises. Without
// this test an insertion that past levels of eps don't know of would pass: its rate pushed the fluid in the next step.
#include <gtest/gtest.h>

#include "tests/verification/cfd_box.h"

using namespace twogrid;

TEST(VoidLevels, ReplacedFluidMovesNothing) {
  for (bool same_flux : {false, true}) {
    const Vec3 begin{0.3, -0.2, 0.1};
    const double before = 0.8, after = 0.6, interval = 0.05;
    FluidSettings s;
    s.density = 1.2, s.viscosity = 0.02, s.dt = interval, s.initial_velocity = begin;
    CfdBox box({uniform(0, 1, 6), uniform(0, 1, 6), graded_nodes(0, 1, 6, 1.1, true)}, {true, true, true}, s);
    box.eps_begin.fill(before), box.eps_end.fill(before);
    box.fluid->start(box.eps_begin);
    for (int n = 0; n < 8; ++n) {
      Interphase exchange;
      if (n == 4) {
        box.eps_begin.fill(after), box.eps_end.fill(after);
        exchange.replaced = true, exchange.same_flux = same_flux;
      }
      box.step(interval, exchange);
      const double factor = n >= 4 && same_flux ? before / after : 1.0;
      for (int d = 0; d < 3; ++d)
        for_each(box.faces(d), [&](int i, int j, int k) {
          EXPECT_NEAR(box.fluid->velocity()[d](i, j, k), factor * begin[d], 1e-12) << "interval " << n;
        });
      for_each(box.own(), [&](int i, int j, int k) {
        EXPECT_NEAR(box.fluid->pressure()(i, j, k), 0, 1e-10) << "interval " << n;
        EXPECT_EQ(box.fluid->void_fraction()(i, j, k), n >= 4 ? after : before);
      });
    }
  }
}
