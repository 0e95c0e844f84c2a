// The halo of seven-point operators on grids of every awkward shape, empty bricks among them.
#include <gtest/gtest.h>
#include <mpi.h>

#include "cfd/parallel/seven_point_halo.h"
#include "tests/unit/cfd/pressure_cases.h"

namespace twogrid_test {
namespace {

// Falsely passes without it: images taken from the wrong side, corner-free halos that miss a brick's neighbour when
// bricks between are empty; add() that is not bring()'s transpose.
TEST(SevenPointHalo, BringsImagesAndAddsThemBack) {
  for (const Problem& p : problems())
    for (bool empty : {false, true}) {
      const Case c(p, empty);
      SevenPointHalo halo(MPI_COMM_WORLD, c.layout.all_cells(), p.n, p.periodic);
      const Box box = c.own.empty() ? Box{} : c.own.grown(1);
      for (auto cells : {SevenPointHalo::Cells::kRed, SevenPointHalo::Cells::kBlack, SevenPointHalo::Cells::kAll}) {
        Array3<double> a(box, -1);
        for_each(c.own, [&](int i, int j, int k) { a(i, j, k) = noise(i, j, k, 4); });
        halo.bring({&a}, cells);
        Array3<double> ones(box, 0);
        if (!c.own.empty())
          for_each(box, [&](int i, int j, int k) {
            Int3 q{i, j, k};
            int outside = 0;
            bool owned = true;
            for (int d = 0; d < 3; ++d) {
              outside += q[d] < c.own.lo[d] || q[d] >= c.own.hi[d];
              if (p.periodic[d]) q[d] = (q[d] + p.n[d]) % p.n[d];
              owned = owned && q[d] >= 0 && q[d] < p.n[d];
            }
            if (outside != 1) return;
            const int colour = (q[0] + q[1] + q[2]) & 1;
            const bool wanted = cells == SevenPointHalo::Cells::kAll || colour == int(cells);
            EXPECT_EQ(a(i, j, k), owned && wanted ? noise(q[0], q[1], q[2], 4) : -1) << p.name;
            ones(i, j, k) = 1;
          });
        halo.add(ones);
        // Each cell has been seen once by each side that has another rank, or a periodic image, beyond it.
        for_each(c.own, [&](int i, int j, int k) {
          int seen = 0;
          const Int3 q{i, j, k};
          for (int d = 0; d < 3; ++d) {
            seen += q[d] == c.own.lo[d] && (q[d] > 0 || p.periodic[d]);
            seen += q[d] == c.own.hi[d] - 1 && (q[d] < p.n[d] - 1 || p.periodic[d]);
          }
          EXPECT_EQ(ones(i, j, k), seen) << p.name;
        });
      }
    }
}

}  // namespace
}  // namespace twogrid_test
