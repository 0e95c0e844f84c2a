// Reading at particles, and the way of the reaction back: fixed-point sums through the transpose.
//
// Without these tests would pass: weights that don't add up to one beside a wall; a kernel or cube cut off at a rank's
// border; a reaction that goes to other places than were read; source terms that change with the number of ranks.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "coupling/ledger.h"
#include "coupling/read.h"
#include "coupling_fakes.h"

namespace twogrid_test {
namespace {

const std::array<Read, 6> kAllReads{Read::kCell,          Read::kTrilinear, Read::kFine,
                                    Read::kFineTrilinear, Read::kKernel,    Read::kCube};

struct ReadScene {
  FineGrid grid;
  Layout layout;
  std::unique_ptr<FakeFluid> fluid;
  std::unique_ptr<Reader> reader;
  Bodies bodies;
  ReadScene(MPI_Comm comm, Read read, std::array<bool, 3> periodic, double stretch, double width = 0.33)
      : grid(make_grid({0, 0, 0}, {1, 1, 2}, {8, 8, 16}, periodic, {stretch, stretch, 1})),
        layout(make_layout(grid, size_of(comm), {2, 4, 2})) {
    fluid = std::make_unique<FakeFluid>(comm, grid, layout);
    const double w = read == Read::kKernel || read == Read::kCube ? width : 0.0;
    reader = std::make_unique<Reader>(comm, *fluid,
                                      ParticleGrid(grid, reads_fine_cells(read) ? Int3{1, 1, 1} : Int3{2, 4, 2}),
                                      make_region(grid, comm, 0.02), read, w);
    Bodies all;
    std::mt19937 random(9);
    std::uniform_real_distribution<double> u(0, 1);
    for (int q = 0; q < 200; ++q) {
      Vec3 x{u(random), u(random), 2 * u(random)};
      if (q % 5 == 0) x[q % 3] = q % 2 ? -0.02 : (q % 3 == 2 ? 2.02 : 1.02);  // half a skin outside
      if (q % 7 == 0) x[2] = grid.axis[2].node(q % 16);
      all.add(x, 0.01, 1000, {0, 0, 0}, q + 1);
    }
    bodies = share_of(all, grid, comm);
  }
};

double total(double mine) {
  double all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return all;
}

TEST(Reading, UniformVelocityIsExactEverywhere) {
  for (Read read : kAllReads)
    for (int sides = 0; sides < 2; ++sides) {
      ReadScene s(MPI_COMM_WORLD, read, {sides == 1, false, sides == 1}, 1.08);
      s.fluid->set(s.fluid->u_, [](int d, const Vec3&) { return 1.5 - d; });
      CellField<ParticleGrid> eps;
      eps.reset(s.reader->map().own(), 0.45);
      s.reader->load(s.fluid->u_, eps);
      Stencil w;
      double out[4];
      for (auto& x : s.bodies.x) {
        ASSERT_TRUE(s.reader->window().covers(x.data()));
        s.reader->weights(x.data(), w);
        s.reader->at<4>(w, out);
        for (int d = 0; d < 3; ++d) EXPECT_NEAR(out[d], 1.5 - d, 1e-14) << "read " << int(read);
        EXPECT_NEAR(out[3], 0.45, 1e-14);
      }
    }
}

// Linear interpolation reads a linear field exactly inside; means read it at the centre of what they average over; the
// quadratic spline, integrated over cells, does when its width is three cells.
TEST(Reading, LinearVelocity) {
  auto profile = [](int d, const Vec3& x) { return 0.2 + d + 0.5 * x[0] - 0.7 * x[1] + 0.3 * x[2]; };
  for (Read read : kAllReads) {
    const double width = read == Read::kKernel ? 3 * 0.125 : 0.33;
    ReadScene s(MPI_COMM_WORLD, read, {false, false, false}, 1.0, width);
    for (int d = 0; d < 3; ++d) s.fluid->open_side(d, false), s.fluid->open_side(d, true);
    s.reader = std::make_unique<Reader>(MPI_COMM_WORLD, *s.fluid, s.reader->map().grid(),
                                        make_region(s.grid, MPI_COMM_WORLD, 0.02), read,
                                        read == Read::kKernel || read == Read::kCube ? width : 0.0);
    s.fluid->set(s.fluid->u_, profile);
    s.reader->load(s.fluid->u_);
    Stencil w;
    double out[3];
    for (auto& b : s.bodies.x) {
      const double margin[3] = {0.27, 0.27, 0.27};
      bool inner = true;
      for (int d = 0; d < 3; ++d) inner = inner && b[d] > margin[d] && b[d] < s.grid.axis[d].hi() - margin[d];
      if (!inner) continue;
      Vec3 at{b[0], b[1], b[2]};
      const ParticleGrid& g = s.reader->map().grid();
      if (read == Read::kCell || read == Read::kFine)
        for (int d = 0; d < 3; ++d) at[d] = g.axis[d].centre(g.axis[d].find(b[d]));
      if (read == Read::kCube)  // the mean of cell values over a cube, by its own sum over the cells
        for (int d = 0; d < 3; ++d) {
          at[d] = 0;
          for (int i = 0; i < g.n()[d]; ++i)
            at[d] += g.axis[d].centre(i) / width *
                     std::max(0.0, std::min(g.axis[d].node(i + 1), b[d] + width / 2) -
                                       std::max(g.axis[d].node(i), b[d] - width / 2));
        }
      s.reader->weights(b.data(), w);
      s.reader->at<3>(w, out);
      for (int d = 0; d < 3; ++d) EXPECT_NEAR(out[d], profile(d, at), 1e-13) << "read " << int(read);
    }
  }
}

TEST(Reading, ReactionIsTheTransposeOnAnyRanks) {
  double worst = 0;
  for (Read read : kAllReads)
    for (int sides = 0; sides < 2; ++sides) {
      const std::array<bool, 3> periodic{sides == 1, false, sides == 1};
      FaceField<FineGrid> source[2], beta[2];
      int run = 0;
      for (MPI_Comm comm : {MPI_COMM_WORLD, MPI_COMM_SELF}) {
        ReadScene s(comm, read, periodic, 1.08);
        s.fluid->set(s.fluid->u_, [](int d, const Vec3& x) {
          return std::sin(2 * M_PI * x[0] + d) + std::cos(2 * M_PI * x[1]) + std::sin(M_PI * x[2] + 0.3);
        });
        s.reader->load(s.fluid->u_);
        const std::array<FixedPoint, 2> scale{FixedPoint(3.0, 200), FixedPoint(1.0, 200)};
        s.reader->clear_reaction();
        Stencil w;
        double u[3];
        std::array<Sum, 3> read_side, given;
        Sum size;
        for (std::size_t q = 0; q < s.bodies.x.size(); ++q) {
          s.reader->weights(s.bodies.x[q].data(), w);
          s.reader->at<3>(w, u);
          std::array<long long, 4> i;
          for (int d = 0; d < 3; ++d) {
            const double f = std::sin(s.bodies.tag[q] + d) * 2.5;
            i[d] = scale[0].quantise(f);
            read_side[d] += f * u[d];
            given[d] += f;
            size += std::abs(f);
          }
          i[3] = scale[1].quantise(0.5);
          s.reader->react(w, i);
        }
        Vec3 held;
        NodeSpread made_source, made_beta;
        s.reader->collect(scale, made_source, made_beta, held);
        for (int d = 0; d < 3; ++d) made_source.field(d, source[run][d]), made_beta.field(d, beta[run][d]);
        if (comm == MPI_COMM_WORLD)
          for (int d = 0; d < 3; ++d) {
            Sum face_side, received, coefficient;
            received += held[d];
            for_each(s.reader->map().faces(d), [&](int i, int j, int k) {
              const double v = s.reader->map().face_volume(d, i, j, k), f = source[run][d](i, j, k) * v;
              if (source[run][d](i, j, k) != 0) face_side += f * s.fluid->u_[d](i, j, k);
              received += f;
              coefficient += v * beta[run][d](i, j, k);
            });
            const double all = total(size.value());
            worst = std::max(worst, std::abs(total(read_side[d].value()) - total(face_side.value())) / all);
            worst = std::max(worst, std::abs(total(given[d].value()) - total(received.value())) / all);
            EXPECT_NEAR(total(coefficient.value()), 100, 1e-11);  // 200 particles of 0.5
          }
        ++run;
      }
      long long differ = 0;
      for (int d = 0; d < 3; ++d)
        for_each(source[0][d].box(), [&](int i, int j, int k) {
          differ += source[0][d](i, j, k) != source[1][d](i, j, k);
          differ += beta[0][d](i, j, k) != beta[1][d](i, j, k);
        });
      EXPECT_EQ(differ, 0) << "read " << int(read);
    }
  EXPECT_LT(worst, 1e-14);
  if (rank_of(MPI_COMM_WORLD) == 0)
    std::printf("             action and reaction: largest relative error %.1e\n", worst);
}

}  // namespace
}  // namespace twogrid_test
