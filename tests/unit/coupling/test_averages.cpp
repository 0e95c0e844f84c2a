// The means and batches of a run's file, read back by one rank and compared with sums of the formulas that were written.
#include <gtest/gtest.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "cfd/parallel/ranks.h"
#include "coupling/output/averages.h"
#include "tests/unit/coupling/output_fakes.h"

namespace twogrid_test {
namespace {

class AveragesTest : public OutputTest {};

// Without it, particles that lie beyond their rank's cells or just outside a periodic side would be lost from the means
// or counted in the wrong cell, and batches that don't partition the run would give wrong error bars: both look normal.
TEST_F(AveragesTest, MeansAndBatchesEqualDirectSums) {
  settings_.output.every = 0;
  settings_.output.average_from = 0.02;  // samples 2 ... 38
  {
    Output output(MPI_COMM_WORLD, settings_, fluid_, {});
    output.begin(0, 0);
    for (int n = 0; n < 39; ++n) {
      fluid_.set(n);
      Cloud cloud(30);
      for (std::size_t i = 0; i < cloud.tag.size(); ++i) {
        cloud.v[i][2] += 0.1 * n;
        if (cloud.tag[i] == 0) cloud.x[i][0] = -1e-5;         // belongs to the last cell in x
        if (cloud.tag[i] == 1) cloud.x[i][0] = 0.012 + 1e-5;  // to the first one
        if (cloud.tag[i] == 2) cloud.x[i][2] = 0.0301;        // above the domain: to none
      }
      output.average(0.01, cloud.view(), 0);
      if (n == 20) output.finish();              // a first run's end must not disturb the sums
      if (n == 25) output.averages()->gather();  // nor must a checkpoint
    }
    output.finish();
  }
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0) {
    ReadBack file(settings_.output.file);
    ASSERT_TRUE(file.is_open());
    EXPECT_FALSE(file.has("/fluid"));
    const int samples = 37, nx = 4, ny = 2, nz = 4;
    const std::string fine = "/average/fine/", coarse = "/average/particle_grid/";
    // Fine grid.
    const auto eps = file.values(fine + "eps"), flux = file.values(fine + "flux"),
               pv = file.values(fine + "p_variance");
    std::size_t c = 0;
    for_each(Box{{0, 0, 0}, {12, 4, 16}}, [&](int i, int j, int k) {
      double e = 0, f[3] = {0, 0, 0}, p = 0, p2 = 0;
      for (int n = 2; n < 39; ++n) {
        const double en = FormulaFluid::eps_at(i, j, k, n), pn = FormulaFluid::p_at(i, j, k, n);
        e += en, p += pn;
        for (int d = 0; d < 3; ++d) f[d] += en * fluid_.centre_velocity(d, i, j, k, n);
      }
      for (int n = 2; n < 39; ++n) p2 += std::pow(FormulaFluid::p_at(i, j, k, n) - p / samples, 2);
      EXPECT_NEAR(eps[c], e / samples, 1e-13);
      for (int d = 0; d < 3; ++d) EXPECT_NEAR(flux[3 * c + d], f[d] / samples, 1e-11);
      EXPECT_NEAR(pv[c], p2 / samples, 1e-8 * p2 / samples);
      ++c;
    });
    // Particle grid. Batches: 37 samples are 9 batches of 4 and one of 1.
    const auto weight = file.values(coarse + "batch/weight"), u = file.values(coarse + "gas_velocity"),
               bu = file.values(coarse + "batch/gas_velocity"), bs = file.values(coarse + "batch/solids_flux"),
               bf = file.values(coarse + "batch/solids_fraction"), fraction = file.values(coarse + "solids_fraction"),
               sv = file.values(coarse + "solids_velocity"), svv = file.values(coarse + "solids_velocity_variance"),
               ev = file.values(coarse + "eps_variance");
    ASSERT_EQ(weight.size(), 16u);
    for (int b = 0; b < 16; ++b) EXPECT_NEAR(weight[b], b < 9 ? 0.04 : b == 9 ? 0.01 : 0, 1e-15);
    const FineGrid& g = fluid_.grid();
    c = 0;
    for_each(Box{{0, 0, 0}, {nx, ny, nz}}, [&](int I, int J, int K) {
      double volume = 0, mean[39] = {}, eps_mean[39] = {}, mean_u[3] = {0, 0, 0};
      for_each(Box{{3 * I, 2 * J, 4 * K}, {3 * I + 3, 2 * J + 2, 4 * K + 4}}, [&](int i, int j, int k) {
        volume += g.volume(i, j, k);
        for (int n = 2; n < 39; ++n) {
          mean[n] += g.volume(i, j, k) * fluid_.centre_velocity(2, i, j, k, n);
          for (int d = 0; d < 3; ++d) mean_u[d] += g.volume(i, j, k) * fluid_.centre_velocity(d, i, j, k, n);
          eps_mean[n] += g.volume(i, j, k) * FormulaFluid::eps_at(i, j, k, n);
        }
      });
      // Particles of this cell, by comparison of coordinates with its sides.
      double solid = 0, momentum = 0, square = 0;
      auto speed = [&](int id, int n) { return Cloud::value(id, 2) + 0.1 * n; };
      std::vector<int> here;
      for (int id = 0; id < 30; ++id) {
        Vec3 x = Cloud::position(id);
        if (id % 5 == 4 || id == 2) continue;
        if (id == 0) x[0] = 0.012 - 1e-5;
        if (id == 1) x[0] = 1e-5;
        const int lo[3] = {3 * I, 2 * J, 4 * K};
        bool in = true;
        for (int d = 0; d < 3; ++d)
          in = in && x[d] >= g.axis[d].node(lo[d]) && x[d] < g.axis[d].node(lo[d] + settings_.ratio[d]);
        if (in) here.push_back(id);
      }
      auto ball = [&](int id) { return 4.0 / 3 * M_PI * std::pow(Cloud::radius_of(id), 3); };
      for (int id : here)
        for (int n = 2; n < 39; ++n) {
          solid += ball(id), momentum += ball(id) * speed(id, n), square += ball(id) * std::pow(speed(id, n), 2);
        }
      EXPECT_NEAR(fraction[c], solid / samples / volume, 1e-12 * fraction[c]);
      if (here.empty()) {
        EXPECT_TRUE(std::isnan(sv[3 * c + 2]));
      } else {
        const double m = momentum / solid;
        EXPECT_NEAR(sv[3 * c + 2], m, 1e-12 * m);
        EXPECT_NEAR(svv[3 * c + 2], square / solid - m * m, 1e-11 * square / solid);
      }
      double eps_total = 0, eps_square = 0;
      for (int n = 2; n < 39; ++n) eps_total += eps_mean[n] / volume;
      for (int n = 2; n < 39; ++n) eps_square += std::pow(eps_mean[n] / volume - eps_total / samples, 2);
      for (int d = 0; d < 3; ++d) EXPECT_NEAR(u[3 * c + d], mean_u[d] / volume / samples, 1e-11);
      EXPECT_NEAR(ev[c], eps_square / samples, 1e-13);
      for (int b = 0; b < 10; ++b) {
        const int first = 2 + 4 * b, last = std::min(39, first + 4);
        double sum = 0, through = 0;
        for (int n = first; n < last; ++n) {
          sum += mean[n] / volume;
          for (int id : here) through += ball(id) * speed(id, n) / volume;
        }
        const std::size_t at = 3 * (b * nx * ny * nz + c) + 2;
        EXPECT_NEAR(bu[at], sum / (last - first), 1e-11);
        EXPECT_NEAR(bs[at], through / (last - first), 1e-12 * std::abs(bs[at]));
        const double filled = solid / samples / volume;  // the particles stay where they are
        EXPECT_NEAR(bf[b * nx * ny * nz + c], filled, 1e-12 * filled);
      }
      ++c;
    });
    EXPECT_EQ(check_xdmf(directory_ + "/bed_average.xdmf", file), 3 + 7 + 3 + 11);
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

// Without it, a run that goes on from a checkpoint could have other means than one that was never left: a restart changes
// the order of the particles in memory.
TEST_F(AveragesTest, TheOrderOfParticlesDoesNotCount) {
  std::vector<double> sums[2];
  for (int turned = 0; turned < 2; ++turned) {
    Averages averages(MPI_COMM_WORLD, fluid_.grid(), fluid_.layout(), ParticleGrid(fluid_.grid(), settings_.ratio));
    Cloud cloud(400);
    for (std::size_t i = 0; i < cloud.v.size(); ++i) cloud.v[i] = {std::sin(1.0 + cloud.tag[i]), 0.3, 1e-3};
    if (turned) {
      std::reverse(cloud.x.begin(), cloud.x.end()), std::reverse(cloud.v.begin(), cloud.v.end());
      std::reverse(cloud.radius.begin(), cloud.radius.end()), std::reverse(cloud.mask.begin(), cloud.mask.end());
    }
    for (int n = 0; n < 20; ++n) averages.add(0.01 / (n + 3), fluid_, cloud.view());
    averages.gather();
    const auto& t = averages.state().solids;
    sums[turned].assign(t.data(), t.data() + t.size());
  }
  EXPECT_TRUE(sums[0] == sums[1]);
}

// Without it, a part of the sums could be carried along for nothing, or be lost at a restart: the means of a long run
// would begin anew in silence, or their batches overlap.
TEST_F(AveragesTest, GoOnFromTheirEntriesAndNeedEachOfThem) {
  const ParticleGrid coarse(fluid_.grid(), settings_.ratio);
  const auto add = [&](Averages& a, int from, int to) {
    for (int n = from; n < to; ++n) {
      fluid_.set(n);
      Cloud cloud(60);
      for (auto& v : cloud.v) v[2] += 0.1 * n;
      a.add(0.01 / (n + 3), fluid_, cloud.view());
    }
  };
  const auto bits = [](AveragesState& s) {
    std::string all;
    AveragesState::for_each_entry(s, [&](const std::string&, const auto& entry) {
      if constexpr (std::is_arithmetic_v<std::decay_t<decltype(entry)>>)
        all.append(reinterpret_cast<const char*>(&entry), sizeof entry);
      else
        all.append(reinterpret_cast<const char*>(entry.data()), entry.size() * sizeof(double));
    });
    return all;
  };
  // All batches are in use, the last one half full; then they are merged.
  Averages whole(MPI_COMM_WORLD, fluid_.grid(), fluid_.layout(), coarse);
  add(whole, 0, 31), whole.gather();
  const AveragesState then = whole.state();
  add(whole, 31, 40), whole.gather();
  const std::string right = bits(whole.state());
  std::vector<std::string> names{""};
  AveragesState::for_each_entry(then, [&](const std::string& name, const auto&) { names.push_back(name); });
  EXPECT_EQ(names.size(), 1u + 8 + 3 * AveragesState::kBatches);
  for (const std::string& but : names) {
    Averages other(MPI_COMM_WORLD, fluid_.grid(), fluid_.layout(), coarse);
    AveragesState fresh = other.state();
    std::map<std::string, double> numbers;
    AveragesState::for_each_entry(fresh, [&](const std::string& name, auto& entry) {
      if constexpr (std::is_arithmetic_v<std::decay_t<decltype(entry)>>) numbers[name] = double(entry);
    });
    other.state() = then;
    AveragesState::for_each_entry(other.state(), [&](const std::string& name, auto& entry) {
      using T = std::decay_t<decltype(entry)>;
      if (name != but) return;
      if constexpr (std::is_arithmetic_v<T>)
        entry = T(numbers.at(name));
      else
        std::fill(entry.data(), entry.data() + entry.size(), 0.0);
    });
    add(other, 31, 40), other.gather();
    int differs = bits(other.state()) != right;
    MPI_Allreduce(MPI_IN_PLACE, &differs, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    EXPECT_EQ(differs, but.empty() ? 0 : 1) << "without " << but;
  }
}

}  // namespace
}  // namespace twogrid_test
