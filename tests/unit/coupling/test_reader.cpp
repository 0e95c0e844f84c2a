// Reading at particles, and the way of the reaction back: fixed-point sums through the transpose.
//
// Without these tests would pass: weights that don't add up to one beside a wall; a kernel or cube cut off at a rank's
// border; a reaction that goes to other places than were read; source terms that change with the number of ranks.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numeric>

#include "cfd/parallel/ranks.h"
#include "coupling/particles/ledger.h"
#include "coupling/two_grid/fixed_point.h"
#include "coupling/two_grid/reader.h"
#include "tests/unit/coupling/coupling_fakes.h"

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
        layout(make_layout(grid, ranks_of(comm), {2, 4, 2})) {
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

  /// f(q, place) for all bodies.
  template <class F>
  void for_all(F f) {
    const Particles p = bodies.view();
    std::vector<int> who(p.n);
    std::iota(who.begin(), who.end(), 0);
    Places places;
    reader->find(p, who, places);
    reader->at_places(p, who, places, f);
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
      s.reader->load({{&s.fluid->u_, &eps}});
      s.for_all([&](std::size_t q, const auto& place) {
        EXPECT_TRUE(s.reader->window().covers(s.bodies.x[q].data()));
        Four out;
        s.reader->at<1>(place, &out);
        for (int d = 0; d < 3; ++d) EXPECT_NEAR(out[d], 1.5 - d, 1e-14) << "read " << int(read);
        EXPECT_NEAR(out[3], 0.45, 1e-14);
      });
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
    s.reader->load({{&s.fluid->u_}});
    s.for_all([&](std::size_t q, const auto& place) {
      const auto& b = s.bodies.x[q];
      const double margin[3] = {0.27, 0.27, 0.27};
      bool inner = true;
      for (int d = 0; d < 3; ++d) inner = inner && b[d] > margin[d] && b[d] < s.grid.axis[d].hi() - margin[d];
      if (!inner) return;
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
      Four out;
      s.reader->at<1>(place, &out);
      for (int d = 0; d < 3; ++d) EXPECT_NEAR(out[d], profile(d, at), 1e-13) << "read " << int(read);
    });
  }
}

// A bed that ends inside the domain, its void fraction jumping from 0.45 to 1 between two nodes, crossed by a uniform
// flux: u = U/eps on either side, something between on the faces at the jump. What is seen is the velocity and the void
// fraction of the particle's own side, whatever is read and in whatever direction the bed ends. The plain mean is short
// by 5 % in the last node and by a third between nodes.
TEST(Reading, SeesItsOwnSideWhereABedEnds) {
  for (Read read : kAllReads)
    for (int d = 0; d < 3; ++d)
      for (bool high : {false, true}) {
        ReadScene s(MPI_COMM_WORLD, read, {false, false, false}, 1.08);
        const FineGrid& grid = s.grid;
        const double surface = grid.axis[d].node(grid.axis[d].n() / 2), U = 0.3;
        auto eps_at = [&](const Vec3& x) { return (x[d] < surface) != high ? 0.45 : 1.0; };
        CellField<FineGrid> fine;
        fine.reset(s.fluid->eps_.box());
        for_each(fine.box(), [&](int i, int j, int k) {
          Int3 c{i, j, k};
          Vec3 x;
          for (int e = 0; e < 3; ++e) x[e] = grid.axis[e].centre(std::clamp(c[e], 0, grid.axis[e].n() - 1));
          fine(i, j, k) = eps_at(x);
        });
        for_each(s.fluid->u_[d].box(), [&](int i, int j, int k) {
          Int3 c{i, j, k}, below = c;
          --below[d];
          const Axis& a = grid.axis[d];
          if (c[d] < 1 || c[d] > a.n() - 1) return;
          const double w = a.width(c[d]) / (a.width(c[d]) + a.width(below[d]));
          s.fluid->u_[d](i, j, k) = fine.box().contains(below[0], below[1], below[2]) && fine.box().contains(i, j, k)
                                        ? U / (w * fine(i, j, k) + (1 - w) * fine(below[0], below[1], below[2]))
                                        : 0.0;
        });
        CellField<ParticleGrid> eps;
        eps.reset(s.reader->map().own());
        const ParticleGrid& nodes = s.reader->map().grid();
        for_each(eps.box(), [&](int i, int j, int k) {
          eps(i, j, k) = eps_at({nodes.axis[0].centre(i), nodes.axis[1].centre(j), nodes.axis[2].centre(k)});
        });
        s.reader->load({{&s.fluid->u_, &eps, &fine}, {&s.fluid->u_}});
        s.for_all([&](std::size_t q, const auto& place) {
          const auto& x = s.bodies.x[q];
          // From the empty side the bed may be seen; between unequal cells "nearer to a centre" is not "inside a node".
          const double away = high ? x[d] - surface : surface - x[d];
          if (away < 0.02) return;
          Four out[2];
          s.reader->at<2>(place, out);
          see_like_home<2>(place, s.reader->shape(), s.reader->field(), out[0]);
          EXPECT_NEAR(out[0][d], U / 0.45, 1e-13) << "read " << int(read) << " along " << d;
          EXPECT_NEAR(out[0][3], 0.45, 1e-14) << "read " << int(read) << " along " << d;
        });
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
        s.reader->load({{&s.fluid->u_}});
        const std::array<FixedPoint, 2> scale{FixedPoint(3.0, 200), FixedPoint(1.0, 200)};
        s.reader->clear_reaction();
        std::array<Sum, 3> read_side, given;
        Sum size;
        s.for_all([&](std::size_t q, const auto& place) {
          Four u, i;
          s.reader->at<1>(place, &u);
          for (int d = 0; d < 3; ++d) {
            const double f = std::sin(s.bodies.tag[q] + d) * 2.5;
            i[d] = scale[0].whole(f);
            read_side[d] += f * u[d];
            given[d] += f;
            size += std::abs(f);
          }
          i[3] = scale[1].whole(0.5);
          s.reader->react(place, i);
        });
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

// Nodes and corners are short forms of a stencil: the same weights, and whole numbers that arrive in full.
TEST(Reading, ShortPlacesAreStencils) {
  for (Read read : {Read::kCell, Read::kTrilinear})
    for (int sides = 0; sides < 4; ++sides) {
      ReadScene s(MPI_COMM_WORLD, read, {sides % 2 == 1, false, sides % 2 == 1}, sides < 2 ? 1.08 : 1.0);
      const Window& window = s.reader->window();
      std::vector<FourNumbers> field(window.box().count());
      std::mt19937 random(3);
      std::uniform_real_distribution<double> u(-1, 1);
      for (FourNumbers& f : field) f = {u(random), u(random), u(random), u(random)};
      std::vector<FourWholeNumbers> sum(field.size()), expected(field.size());
      s.for_all([&](std::size_t q, const auto& place) {
        Stencil w;
        window.weights(s.bodies.x[q].data(), w);
        Four one, other;
        gather<1>(place, window.shape(), field.data(), &one);
        gather<1>(w, window.shape(), field.data(), &other);
        for (int c = 0; c < 4; ++c) EXPECT_NEAR(one[c], other[c], 1e-15);
        const Four total{1e15, -3, 7654321, double(q)};
        scatter(place, window.shape(), total, sum.data());
        scatter(w, window.shape(), total, expected.data());
      });
      for (std::size_t m = 0; m < sum.size(); ++m)
        for (int c = 0; c < 4; ++c) EXPECT_NEAR(double(sum[m].at[c] - expected[m].at[c]), 0, c == 0 ? 200 : 40);
      Four all{0, 0, 0, 0};
      for (const FourWholeNumbers& f : sum)
        for (int c = 0; c < 4; ++c) all[c] += double(f.at[c]);
      const double n = double(s.bodies.x.size());
      EXPECT_EQ(all[1], -3 * n);
      EXPECT_EQ(all[2], 7654321 * n);
      EXPECT_EQ(all[3], n * (n - 1) / 2);
    }
}

// On sides of nodes, beyond the window, and where the position is not a number, the way for many particles at once
// takes the same node as that for one. A wild index would end the run without a word.
TEST(Reading, NodesOfManyAtOnceAreThoseOfOne) {
  const double nan = std::nan("");
  for (double stretch : {1.0, 1.08})
    for (bool periodic : {false, true}) {
      ReadScene s(MPI_COMM_WORLD, Read::kCell, {periodic, periodic, periodic}, stretch);
      const Window& window = s.reader->window();
      Bodies bodies;
      for (int q = 0; q < 16; ++q)
        for (double off : {0.0, 1e-17, -1e-16, 1e-9, -1e-9, 0.3})
          bodies.add({window.span(0).node[q % window.span(0).node.size()] + off,
                      window.span(1).node[q % window.span(1).node.size()] - off,
                      window.span(2).node[q % window.span(2).node.size()] + off},
                     0.01, 1000);
      bodies.add({-1e9, 1e9, 0}, 0.01, 1000);
      bodies.add({nan, 0.5, nan}, 0.01, 1000);
      bodies.add({0.5, nan, 1e300}, 0.01, 1000);
      const Particles p = bodies.view();
      std::vector<int> who(p.n);
      std::iota(who.begin(), who.end(), 0);
      Places places;
      s.reader->find(p, who, places);
      for (int q = 0; q < p.n; ++q) {
        EXPECT_EQ(places.node[q], window.node(p.x[q])) << q;
        EXPECT_GE(places.node[q], 0);
        EXPECT_LT(places.node[q], std::ptrdiff_t(window.box().count()));
      }
    }
}

// Such a particle ends the run with a sentence, but not before sums have been made with it: its weights are numbers
// that add up to 1, and its share is an integer. (A conversion of a NaN to an integer may be anything.)
TEST(Reading, WeightsOfWhatIsNotFinite) {
  for (bool periodic : {false, true}) {
    const FineGrid grid = make_grid({0, 0, 0}, {1, 1, 1}, {8, 8, 8}, {periodic, periodic, periodic});
    const ParticleGrid nodes(grid, {1, 1, 1});
    const Layout layout = make_layout(grid, 1, {1, 1, 1});
    for (Spread spread : {Spread::kCell, Spread::kLinear, Spread::kKernel, Spread::kCube}) {
      const Window window(MPI_COMM_SELF, nodes, layout, {{0, 0, 0}, {1, 1, 1}, 0.1}, spread, 0.3);
      for (double x : {double(NAN), HUGE_VAL, -HUGE_VAL}) {
        const double at[3] = {0.4, x, 0.6};
        Stencil s;
        window.weights(at, s);
        for (int d = 0; d < 3; ++d) {
          double sum = 0;
          for (int i = 0; i < s.n[d]; ++i) sum += s.w[d][i];
          EXPECT_NEAR(sum, 1, 1e-14) << "spread " << int(spread) << ", " << x;
          EXPECT_TRUE(s.lo[d] >= window.span(d).lo && s.lo[d] + s.n[d] <= window.span(d).hi);
        }
      }
    }
  }
  for (double x : {double(NAN), HUGE_VAL, -HUGE_VAL, 1e300}) {
    EXPECT_EQ(FixedPoint(1.0, 1.0).quantise(x), 0);
    EXPECT_EQ(FixedPoint(1.0, 1.0).whole(x), 0.0);
    for (int c = 0; c < 4; ++c) {
      Four values{0.4, -0.3, 0.2, 0.1};
      values *= FixedPoint(1.0, 1.0).per_unit();
      const Four good = values;
      values[c] = x;
      FixedPoint::to_whole(values);
      for (int e = 0; e < 4; ++e) EXPECT_EQ(values[e], e == c ? 0.0 : std::nearbyint(good[e]));
    }
  }
}

// Around a period of one or two nodes a particle may lie further outside than they are wide.
TEST(Reading, FewNodesAroundAPeriod) {
  for (int n : {1, 2, 3, 4, 9}) {
    const FineGrid grid = make_grid({0, 0, 0}, {0.1 * n, 1, 1}, {n, 4, 4}, {true, false, false});
    const ParticleGrid nodes(grid, {1, 1, 1});
    const Layout layout = make_layout(grid, 1, {1, 1, 1});
    const Window window(MPI_COMM_SELF, nodes, layout, {{0, 0, 0}, {0.1 * n, 1, 1}, 0.16}, Spread::kLinear, 0.0);
    for (double x = -0.159; x < 0.1 * n + 0.159; x += 0.003) {
      int lower;
      double w;
      window.span(0).between(x, lower, w);
      EXPECT_TRUE(w >= 0 && w <= 1) << w << ", " << n << " nodes";
      EXPECT_NEAR(window.span(0).centre[lower] + 0.1 * w, x, 1e-14) << n << " nodes";
    }
  }
}

}  // namespace
}  // namespace twogrid_test
