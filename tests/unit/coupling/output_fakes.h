// For tests of the output: a fluid and particles by formula, and what one rank reads back through HDF5's serial side.
#pragma once

#include <gtest/gtest.h>
#include <hdf5.h>
#include <mpi.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "cfd/fluid/fluid.h"
#include "cfd/parallel/ranks.h"
#include "coupling/output/output.h"

namespace twogrid_test {

using namespace twogrid;

/// Fields are given functions of the global index (periodic images wrapped) and of a counter `now`.
class FormulaFluid : public Fluid {
 public:
  // 12 x 4 x 16 cells of ratio 3 x 2 x 4, periodic in x, stretched in z. On 8 ranks one brick is empty in z.
  FormulaFluid() {
    grid_.axis[0] = Axis(graded_nodes(0, 0.012, 12), true);
    grid_.axis[1] = Axis(graded_nodes(-0.002, 0.002, 4), false);
    grid_.axis[2] = Axis(graded_nodes(0, 0.03, 16, 1.05), false);
    std::array<std::vector<int>, 3> cuts;
    const int p = ranks_of(MPI_COMM_WORLD);
    const int px = p % 2 == 0 ? 2 : 1, pz = p / px;
    cuts[0] = cuts_even(grid_.axis[0], px, 3);
    cuts[1] = {0, 4};
    cuts[2] = cuts_even(grid_.axis[2], pz, 4);
    if (pz == 4) cuts[2] = {0, 8, 8, 12, 16};
    layout_ = Layout(grid_, cuts);
    const Box cells = layout_.cells(rank_of(MPI_COMM_WORLD)).grown(kHalo);
    eps_.reset(cells), p_.reset(cells), dilation_.reset(layout_.cells(rank_of(MPI_COMM_WORLD)));
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
    const int r = id % ranks_of(MPI_COMM_WORLD);
    return r == 1 ? 0 : r;
  }

  explicit Cloud(int n) {
    for (int id = 0; id < n; ++id) {
      if (owner(id) != rank_of(MPI_COMM_WORLD)) continue;
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
    if (rank_of(MPI_COMM_WORLD) == 0) {
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
    if (rank_of(MPI_COMM_WORLD) == 0) {
      std::error_code ignored;
      std::filesystem::remove_all(directory_, ignored);
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

inline std::string read_text(const std::string& path) {
  std::ifstream in(path);
  std::stringstream s;
  s << in.rdbuf();
  return s.str();
}

/// Every dataset the XDMF file names must exist with the extent it says, and its elements must be closed.
inline int check_xdmf(const std::string& path, const ReadBack& file) {
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

}  // namespace twogrid_test
