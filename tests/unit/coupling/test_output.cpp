// The files of a run, read back by one rank through HDF5's serial side and compared with values computed from the
// formulas below, not from the arrays that were written.
#include <gtest/gtest.h>
#include <hdf5.h>
#include <mpi.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <functional>
#include <regex>
#include <sstream>

#include "cfd/fluid/fluid.h"
#include "coupling/output/output.h"

namespace {

using namespace twogrid;

int mpi_rank() {
  int r;
  MPI_Comm_rank(MPI_COMM_WORLD, &r);
  return r;
}
int mpi_ranks() {
  int n;
  MPI_Comm_size(MPI_COMM_WORLD, &n);
  return n;
}

/// Fields are given functions of the global index (periodic images wrapped) and of a counter `now`.
class FormulaFluid : public Fluid {
 public:
  // 12 x 4 x 16 cells of ratio 3 x 2 x 4, periodic in x, stretched in z. On 8 ranks one brick is empty in z.
  FormulaFluid() {
    grid_.axis[0] = Axis(graded_nodes(0, 0.012, 12), true);
    grid_.axis[1] = Axis(graded_nodes(-0.002, 0.002, 4), false);
    grid_.axis[2] = Axis(graded_nodes(0, 0.03, 16, 1.05), false);
    std::array<std::vector<int>, 3> cuts;
    const int p = mpi_ranks();
    const int px = p % 2 == 0 ? 2 : 1, pz = p / px;
    cuts[0] = cuts_even(grid_.axis[0], px, 3);
    cuts[1] = {0, 4};
    cuts[2] = cuts_even(grid_.axis[2], pz, 4);
    if (pz == 4) cuts[2] = {0, 8, 8, 12, 16};
    layout_ = Layout(grid_, cuts);
    const Box cells = layout_.cells(mpi_rank()).grown(kHalo);
    eps_.reset(cells), p_.reset(cells), dilation_.reset(layout_.cells(mpi_rank()));
    for (int d = 0; d < 3; ++d) {
      Box faces = cells;
      ++faces.hi[d];
      u_[d].reset(faces), flux_[d].reset(faces), state_[d].reset(faces);
    }
    set(0);
  }

  static double eps_at(int i, int j, int k, double now) {
    return 0.4 + 0.5 * std::fmod(0.37 * i + 0.11 * j + 0.23 * k + 0.17 * now, 1.0);
  }
  static double p_at(int i, int j, int k, double now) { return 100.0 * k + j - 7.0 * i + now * now; }
  static double u_at(int d, int i, int j, int k, double now) { return d + 1 + i * 0.5 - j * 0.25 + k * 0.125 + now; }
  static double flux_at(int d, int i, int j, int k) { return std::sin(1.0 + d + i + 12 * j + 48 * k); }
  static double dilation_at(int i, int j, int k) { return std::cos(2.0 + i + 12 * j + 48 * k); }
  int wrapped(int i) const { return (i % 12 + 12) % 12; }

  void set(double now) {
    now_ = now;
    for_each(eps_.box(), [&](int i, int j, int k) {
      eps_(i, j, k) = eps_at(wrapped(i), j, k, now), p_(i, j, k) = p_at(wrapped(i), j, k, now);
    });
    for_each(dilation_.box(), [&](int i, int j, int k) { dilation_(i, j, k) = dilation_at(i, j, k); });
    for (int d = 0; d < 3; ++d)
      for_each(u_[d].box(), [&](int i, int j, int k) {
        u_[d](i, j, k) = u_at(d, wrapped(i), j, k, now), flux_[d](i, j, k) = flux_at(d, wrapped(i), j, k);
      });
  }
  double centre_velocity(int d, int i, int j, int k, double now) const {
    return 0.5 * (u_at(d, i, j, k, now) + u_at(d, d == 0 ? wrapped(i + 1) : i, j + (d == 1), k + (d == 2), now));
  }

  const FineGrid& grid() const override { return grid_; }
  const Layout& layout() const override { return layout_; }
  double density() const override { return 1.2; }
  double viscosity() const override { return 1.8e-5; }
  const Array3<FaceState>& face_state(int d) const override { return state_[d]; }
  const FaceField<FineGrid>& velocity() const override { return u_; }
  const FaceField<FineGrid>& mean_velocity() const override { return u_; }
  const FaceField<FineGrid>& mean_pressure_gradient() const override { return u_; }
  const CellField<FineGrid>& pressure() const override { return p_; }
  const CellField<FineGrid>& void_fraction() const override { return eps_; }
  bool knows_last_step() const override { return true; }
  double flux(int d, int i, int j, int k) const override { return flux_[d](i, j, k); }
  double void_fraction_rate(int i, int j, int k) const override { return dilation_(i, j, k); }
  double time() const override { return 0.01 * now_; }
  void start(const CellField<FineGrid>&) override {}
  FluidReport advance(double, const VoidFractionInTime&, const Interphase&) override { return {}; }

 private:
  FineGrid grid_;
  Layout layout_;
  double now_ = 0;
  CellField<FineGrid> eps_, p_, dilation_;
  FaceField<FineGrid> u_, flux_;
  std::array<Array3<FaceState>, 3> state_;
};

/// Particle `id` of a global list, known to every rank by formula; owned by rank id % ranks except that rank 1 has
/// none.
struct Cloud {
  std::vector<std::array<double, 3>> x, v, f;
  std::vector<double> radius, mass;
  std::vector<int> tag, mask;
  std::vector<std::vector<double>> state;
  std::vector<double*> rows;

  static Vec3 position(int id) {
    return {0.012 * std::fmod(0.618 * id, 1.0), -0.002 + 0.004 * std::fmod(0.755 * id, 1.0),
            0.03 * std::fmod(0.57 * id, 1.0)};
  }
  static double value(int id, int column) { return id + 0.01 * column; }
  static double radius_of(int id) { return 1e-4 * (1 + id % 3); }
  static int owner(int id) {
    const int r = id % mpi_ranks();
    return r == 1 ? 0 : r;
  }

  explicit Cloud(int n) {
    for (int id = 0; id < n; ++id) {
      if (owner(id) != mpi_rank()) continue;
      x.push_back(position(id));
      v.push_back({value(id, 0), value(id, 1), value(id, 2)});
      f.push_back({value(id, 3), value(id, 4), value(id, 5)});
      radius.push_back(radius_of(id)), mass.push_back(1), tag.push_back(id), mask.push_back(id % 5 == 4 ? 2 : 1);
      std::vector<double> s(kParticleColumns);
      for (int c = 0; c < kParticleColumns; ++c) s[c] = value(id, 10 + c);
      state.push_back(s);
    }
    for (auto& s : state) rows.push_back(s.data());
  }
  Particles view() {
    Particles p;
    p.n = int(x.size());
    auto raw = [](auto& a) { return reinterpret_cast<double(*)[3]>(a.data()); };
    p.x = raw(x), p.v = raw(v), p.f = raw(f);
    p.radius = radius.data(), p.mass = mass.data(), p.tag = tag.data(), p.mask = mask.data();
    p.group = 1;
    p.state = rows.data();
    return p;
  }
};

/// What rank 0 reads with the serial driver.
class ReadBack {
 public:
  explicit ReadBack(const std::string& file) : file_(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT)) {}
  ~ReadBack() {
    if (file_ >= 0) H5Fclose(file_);
  }
  bool is_open() const { return file_ >= 0; }
  bool has(const std::string& path) const {
    for (std::size_t at = path.find('/', 1); at != std::string::npos; at = path.find('/', at + 1))
      if (H5Lexists(file_, path.substr(0, at).c_str(), H5P_DEFAULT) <= 0) return false;
    return H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0;
  }
  std::vector<hsize_t> extent(const std::string& path) const {
    const hid_t set = H5Dopen2(file_, path.c_str(), H5P_DEFAULT), space = H5Dget_space(set);
    std::vector<hsize_t> n(H5Sget_simple_extent_ndims(space));
    H5Sget_simple_extent_dims(space, n.data(), nullptr);
    H5Sclose(space), H5Dclose(set);
    return n;
  }
  std::vector<double> values(const std::string& path) const {
    std::size_t n = 1;
    for (auto e : extent(path)) n *= e;
    std::vector<double> v(n);
    const hid_t set = H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
    EXPECT_GE(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, v.data()), 0) << path;
    H5Dclose(set);
    return v;
  }
  std::string text(const std::string& path) const {
    const hid_t set = H5Dopen2(file_, path.c_str(), H5P_DEFAULT), type = H5Dget_type(set);
    std::string s(H5Tget_size(type), ' ');
    H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, s.data());
    H5Tclose(type), H5Dclose(set);
    return s;
  }
  std::string text_attribute(const std::string& object, const std::string& name) const {
    const hid_t a = H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                type = H5Aget_type(a);
    std::string s(H5Tget_size(type), ' ');
    H5Aread(a, type, s.data());
    H5Tclose(type), H5Aclose(a);
    return s;
  }
  int int_attribute(const std::string& object, const std::string& name) const {
    const hid_t a = H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    int v[8] = {-1};
    H5Aread(a, H5T_NATIVE_INT, v);
    H5Aclose(a);
    return v[0];
  }

 private:
  hid_t file_;
};

/// A directory of its own for each test, removed at its end.
class OutputTest : public ::testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/twogrid_output_XXXXXX";
    if (mpi_rank() == 0) {
      ASSERT_NE(mkdtemp(name), nullptr);
    }
    MPI_Bcast(name, sizeof name, MPI_CHAR, 0, MPI_COMM_WORLD);
    directory_ = name;
    settings_.ratio = {3, 2, 4};
    settings_.output.every = 1;
    settings_.output.file = directory_ + "/bed.h5";
  }
  void TearDown() override {
    MPI_Barrier(MPI_COMM_WORLD);
    if (mpi_rank() == 0) {
      for (const char* f : {"/bed.h5", "/bed.xdmf", "/bed_average.xdmf"}) unlink((directory_ + f).c_str());
      rmdir(directory_.c_str());
    }
    MPI_Barrier(MPI_COMM_WORLD);
  }
  /// The sentence of the exception f throws; empty if it throws none. Every rank must see the same.
  std::string sentence(const std::function<void()>& f) {
    std::string s;
    try {
      f();
    } catch (const std::exception& e) {
      s = e.what();
    }
    int n[2] = {int(s.size()), -int(s.size())};
    MPI_Allreduce(MPI_IN_PLACE, n, 2, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    EXPECT_EQ(n[0], -n[1]) << "ranks disagree: " << s;
    return s;
  }

  std::string directory_;
  Settings settings_;
  FormulaFluid fluid_;
};

std::string read_text(const std::string& path) {
  std::ifstream in(path);
  std::stringstream s;
  s << in.rdbuf();
  return s.str();
}

/// Every dataset the XDMF file names must exist with the extent it says, and its elements must be closed.
int check_xdmf(const std::string& path, const ReadBack& file) {
  const std::string text = read_text(path);
  const std::regex item("<DataItem [^>]*Dimensions=\"([0-9 ]+)\">bed\\.h5:([^<]+)</DataItem>");
  int items = 0;
  for (std::sregex_iterator m(text.begin(), text.end(), item), end; m != end; ++m, ++items) {
    const std::string dataset = (*m)[2];
    if (!file.has(dataset)) {
      ADD_FAILURE() << "XDMF names " << dataset << ", which is not there";
      continue;
    }
    std::istringstream said((*m)[1]);
    std::vector<hsize_t> n;
    for (hsize_t d; said >> d;) n.push_back(d);
    EXPECT_EQ(n, file.extent(dataset)) << dataset;
  }
  for (const char* e : {"Xdmf", "Domain", "Grid", "Attribute", "Geometry"}) {
    const std::string name = e;
    const std::regex open("<" + name + "[ >]"), shut("</" + name + ">");
    auto count = [&](const std::regex& r) {
      return std::distance(std::sregex_iterator(text.begin(), text.end(), r), std::sregex_iterator());
    };
    EXPECT_EQ(count(open), count(shut)) << name;
    EXPECT_GT(count(open), 0) << name;
  }
  return items;
}

// Without it, a wrong offset between a rank's halo and its part of the file, a swapped dimension, or a lost brick would
// pass: pictures would still look plausible. The file is read while the run goes on, with no closing call, as after a
// kill.
TEST_F(OutputTest, FramesHoldTheValuesOfEveryCellFaceAndParticle) {
  settings_.output.fields = {"u", "p", "eps", "faces"};
  Record record{"fix gas all twogrid\nrun 0\n",
                "twogrid -in in.bed",
                {{"LIGGGHTS", "3.8.0"}},
                {{"eps bound", "move 0.3"}, {"boundary", "zlo slip; zhi slip"}}};
  Output output(MPI_COMM_WORLD, settings_, fluid_, record);
  const int particles[3] = {40, 0, 23};  // changes from frame to frame; none at all in the second
  for (int n = 0; n < 3; ++n) {
    fluid_.set(n);
    Cloud cloud(particles[n]);
    output.frame(0.5 * n, 100 * n, cloud.view());
    if (n == 1) output.finish();  // between two runs of one process
  }
  MPI_Barrier(MPI_COMM_WORLD);
  if (mpi_rank() == 0) {
    ReadBack file(settings_.output.file);
    ASSERT_TRUE(file.is_open());
    EXPECT_EQ(file.text("/record/input_text"), record.input_text);
    EXPECT_EQ(file.text_attribute("/record", "command_line"), record.command_line);
    EXPECT_EQ(file.text_attribute("/record", "LIGGGHTS"), "3.8.0");
    for (const auto& [keyword, value] : record.settings)
      EXPECT_EQ(file.text_attribute("/record/settings", keyword.c_str()), value);
    EXPECT_EQ(file.int_attribute("/record", "ranks"), mpi_ranks());
    const char* xyz[3] = {"x", "y", "z"};
    for (int d = 0; d < 3; ++d) {
      const auto fine = fluid_.grid().axis[d].nodes(), coarse = file.values(std::string("/particle_grid/") + xyz[d]);
      EXPECT_EQ(file.values(std::string("/grid/") + xyz[d]), fine);
      ASSERT_EQ(int(coarse.size()), fluid_.grid().axis[d].n() / settings_.ratio[d] + 1);
      for (std::size_t i = 0; i < coarse.size(); ++i) EXPECT_EQ(coarse[i], fine[i * settings_.ratio[d]]);
    }
    for (int n = 0; n < 3; ++n) {
      const std::string at = "/fluid/00000" + std::to_string(n), faces = at + "/faces/";
      EXPECT_EQ(file.values(at + "/time"), std::vector<double>{0.5 * n});
      EXPECT_EQ(file.values(at + "/step"), std::vector<double>{100.0 * n});
      ASSERT_EQ(file.extent(at + "/p"), (std::vector<hsize_t>{16, 4, 12}));
      ASSERT_EQ(file.extent(at + "/u"), (std::vector<hsize_t>{16, 4, 12, 3}));
      const auto p = file.values(at + "/p"), eps = file.values(at + "/eps"), u = file.values(at + "/u"),
                 deps = file.values(faces + "deps_dt");
      int wrong = 0;
      std::size_t c = 0;
      for_each(Box{{0, 0, 0}, {12, 4, 16}}, [&](int i, int j, int k) {
        wrong += p[c] != FormulaFluid::p_at(i, j, k, n);
        wrong += eps[c] != FormulaFluid::eps_at(i, j, k, n);
        wrong += deps[c] != FormulaFluid::dilation_at(i, j, k);
        for (int d = 0; d < 3; ++d) wrong += u[3 * c + d] != fluid_.centre_velocity(d, i, j, k, n);
        ++c;
      });
      for (int d = 0; d < 3; ++d) {
        Int3 size{12, 4, 16};
        if (d > 0) ++size[d];  // x is periodic: its last face is its first
        ASSERT_EQ(file.extent(faces + "u" + xyz[d]),
                  (std::vector<hsize_t>{hsize_t(size[2]), hsize_t(size[1]), hsize_t(size[0])}));
        const auto face = file.values(faces + "u" + xyz[d]), flux = file.values(faces + "flux_" + xyz[d]);
        c = 0;
        for_each(Box{{0, 0, 0}, size}, [&](int i, int j, int k) {
          wrong += face[c] != FormulaFluid::u_at(d, i, j, k, n);
          wrong += flux[c] != FormulaFluid::flux_at(d, i, j, k);
          ++c;
        });
      }
      EXPECT_EQ(wrong, 0) << "frame " << n;

      const std::string points = "/particles/00000" + std::to_string(n);
      int expected = 0;
      for (int id = 0; id < particles[n]; ++id) expected += id % 5 != 4;  // others are not of the group
      ASSERT_EQ(file.extent(points + "/position"), (std::vector<hsize_t>{hsize_t(expected), 3}));
      if (!expected) continue;
      const auto id = file.values(points + "/id"), x = file.values(points + "/position"),
                 v = file.values(points + "/velocity"), f = file.values(points + "/force"),
                 radius = file.values(points + "/radius"), drag = file.values(points + "/drag"),
                 pressure = file.values(points + "/pressure_force"), seen = file.values(points + "/eps");
      std::vector<int> met(particles[n], 0);
      for (int row = 0; row < expected; ++row) {
        const int i = int(id[row]);
        ++met[i];
        for (int d = 0; d < 3; ++d) {
          EXPECT_EQ(x[3 * row + d], Cloud::position(i)[d]);
          EXPECT_EQ(v[3 * row + d], Cloud::value(i, d));
          EXPECT_EQ(f[3 * row + d], Cloud::value(i, 3 + d));
          EXPECT_EQ(drag[3 * row + d], Cloud::value(i, 10 + kDragForce + d));
          EXPECT_EQ(pressure[3 * row + d], Cloud::value(i, 10 + kPressureForce + d));
        }
        EXPECT_EQ(radius[row], Cloud::radius_of(i));
        EXPECT_EQ(seen[row], Cloud::value(i, 10 + kVoidFraction));
      }
      for (int i = 0; i < particles[n]; ++i) EXPECT_EQ(met[i], i % 5 != 4) << "particle " << i;
    }
    // 3 frames of grid (3 + 3 datasets) and 2 of particles (8 datasets).
    EXPECT_EQ(check_xdmf(directory_ + "/bed.xdmf", file), 3 * 6 + 2 * 8);
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

// Without it, particles that lie beyond their rank's cells or just outside a periodic side would be lost from the means
// or counted in the wrong cell, and batches that don't partition the run would give wrong error bars: both look normal.
TEST_F(OutputTest, MeansAndBatchesEqualDirectSums) {
  settings_.output.every = 0;
  settings_.output.average_from = 0.02;  // samples 2 ... 38
  {
    Output output(MPI_COMM_WORLD, settings_, fluid_, {});
    for (int n = 0; n < 39; ++n) {
      fluid_.set(n);
      Cloud cloud(30);
      for (std::size_t i = 0; i < cloud.tag.size(); ++i) {
        cloud.v[i][2] += 0.1 * n;
        if (cloud.tag[i] == 0) cloud.x[i][0] = -1e-5;         // belongs to the last cell in x
        if (cloud.tag[i] == 1) cloud.x[i][0] = 0.012 + 1e-5;  // to the first one
        if (cloud.tag[i] == 2) cloud.x[i][2] = 0.0301;        // above the domain: to none
      }
      output.average(0.01, cloud.view());
      if (n == 20) output.finish();  // a first run's end must not disturb the sums
    }
    output.finish();
  }
  MPI_Barrier(MPI_COMM_WORLD);
  if (mpi_rank() == 0) {
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

// Without it, a second start under the same name could leave frames of the older run behind, which read like new ones.
TEST_F(OutputTest, AStartWritesOverAnOlderFile) {
  for (int run = 0; run < 2; ++run) {
    Output output(MPI_COMM_WORLD, settings_, fluid_, {});
    Cloud cloud(10);
    for (int n = 0; n < 2 - run; ++n) output.frame(n, n, cloud.view());
  }
  MPI_Barrier(MPI_COMM_WORLD);
  if (mpi_rank() == 0) {
    ReadBack file(settings_.output.file);
    ASSERT_TRUE(file.is_open());
    EXPECT_TRUE(file.has("/fluid/000000"));
    EXPECT_FALSE(file.has("/fluid/000001"));
    EXPECT_FALSE(file.has("/fluid/000000/faces"));  // not asked for
    EXPECT_FALSE(file.has("/average"));
    check_xdmf(directory_ + "/bed.xdmf", file);
  }
}

// Without it, a wrong word in a script could be taken in silence, or end one rank only and leave the others waiting.
TEST_F(OutputTest, RefusesWhatCannotBeWrittenInOneSentenceOnAllRanks) {
  auto refusal = [&](const std::string& file, const std::vector<std::string>& fields) {
    settings_.output.file = file;
    settings_.output.fields = fields;
    return sentence([&] { Output output(MPI_COMM_WORLD, settings_, fluid_, {}); });
  };
  const std::string good = directory_ + "/bed.h5";
  EXPECT_NE(refusal(good, {"u", "vorticity"}).find("'vorticity'"), std::string::npos);
  EXPECT_NE(refusal("", {}).find("output file"), std::string::npos);
  EXPECT_NE(refusal(directory_ + "/none/bed.h5", {}).find("No such file or directory"), std::string::npos);
  EXPECT_NE(refusal("/proc/bed.h5", {}).find("cannot be written"), std::string::npos);
  if (mpi_rank() == 0) {
    ASSERT_EQ(symlink("/dev/full", good.c_str()), 0);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_NE(refusal(good, {}).find("not a regular file"), std::string::npos);
}

// Without it, a disk that fills up during the run would hang it (one rank throws, the others wait), or leave a file
// that can't be read any more. The limit on the size of files stands for the full disk.
TEST_F(OutputTest, AFrameThatFindsNoRoomThrowsOnAllRanksAndLeavesTheFileReadable) {
  Output output(MPI_COMM_WORLD, settings_, fluid_, {});
  Cloud cloud(20);
  output.frame(0, 0, cloud.view());
  struct rlimit old;
  getrlimit(RLIMIT_FSIZE, &old);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  struct stat before;
  ASSERT_EQ(stat(settings_.output.file.c_str(), &before), 0);
  MPI_Barrier(MPI_COMM_WORLD);
  struct rlimit tight = old;
  tight.rlim_cur = before.st_size + 10000;
  setrlimit(RLIMIT_FSIZE, &tight);
  const std::string s = sentence([&] { output.frame(1, 1, cloud.view()); });
  setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_NE(s.find("cannot be written"), std::string::npos) << s;
  EXPECT_NE(s.find("output every"), std::string::npos) << s;
  MPI_Barrier(MPI_COMM_WORLD);
  if (mpi_rank() == 0) {
    ReadBack file(settings_.output.file);
    ASSERT_TRUE(file.is_open());
    EXPECT_EQ(file.values("/fluid/000000/p").back(), FormulaFluid::p_at(11, 3, 15, 0));
    EXPECT_FALSE(file.has("/fluid/000001"));
  }
  MPI_Barrier(MPI_COMM_WORLD);
  // With room again it goes on.
  output.frame(2, 2, cloud.view());
  MPI_Barrier(MPI_COMM_WORLD);
  if (mpi_rank() == 0) {
    ReadBack file(settings_.output.file);
    ASSERT_TRUE(file.is_open());
    EXPECT_EQ(file.values("/fluid/000001/time"), std::vector<double>{2});
    check_xdmf(directory_ + "/bed.xdmf", file);
  }
  MPI_Barrier(MPI_COMM_WORLD);
}

}  // namespace
