// A state in a file: what is a rank's own comes back to it, and other ranks share what the numbers add up to.
// Without this test a number that differs from rank to rank, such as the volume that a rank's particles have grown by,
// could come back as another rank's, and an array could lose its halo or what lies beyond the sides.
#include <gtest/gtest.h>
#include <unistd.h>

#include "cfd/parallel/ranks.h"
#include "coupling/checkpoint/state_file.h"
#include "tests/unit/coupling/coupling_fakes.h"

namespace twogrid_test {
namespace {

struct Numbers {
  double own = 0, alike = 0, same = 0;
  int whole = 0;
  bool flag = false;
  CellField<FineGrid> cells;
  CellField<ParticleGrid> nodes, unused;
  CellTable<FineGrid> of_cells;
  CellTable<ParticleGrid> of_nodes;

  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("own_of_rank", s.own), f("alike_of_rank", s.alike), f("same", s.same), f("whole", s.whole), f("flag", s.flag);
    f("cells", s.cells), f("nodes", s.nodes), f("unused", s.unused);
    f("of_cells", s.of_cells), f("of_nodes", s.of_nodes);
  }
};

/// By place in the whole grid: images have the value of what they are images of.
double value(int i, int j, int k) {
  return ((i + 8) % 8) + 100.0 * j + 1e4 * ((k + 16) % 16) + 1.0 / 3;
}

TEST(StateFile, GivesEachRankItsOwnBack) {
  const MPI_Comm comm = MPI_COMM_WORLD;
  const int rank = rank_of(comm), ranks = ranks_of(comm);
  const FineGrid grid = make_grid({0, 0, 0}, {1, 1, 2}, {8, 8, 16}, {true, false, true});
  const ParticleGrid coarse(grid, {2, 2, 2});
  int pid = getpid();
  MPI_Bcast(&pid, 1, MPI_INT, 0, comm);
  const std::string path = "/tmp/twogrid_state_" + std::to_string(pid) + ".h5";
  const auto fill = [&](Array3<double>& a) {
    for_each(a.box(), [&](int i, int j, int k) { a(i, j, k) = value(i, j, k); });
  };
  const Layout cells = make_layout(grid, ranks, {2, 2, 2}), nodes = node_layout(cells, coarse);
  Numbers given;
  given.own = rank + 0.1, given.alike = 0.25, given.same = 1.0 / 3, given.whole = -7, given.flag = true;
  given.cells.reset(cells.cells(rank).grown(2)), given.nodes.reset(nodes.cells(rank));
  fill(given.cells), fill(given.nodes);
  // Column q of a cell: its value and q.
  const auto each = [](auto& table, auto f) {
    std::size_t c = 0;
    for_each(table.own(), [&](int i, int j, int k) {
      for (int q = 0; q < table.columns(); ++q) f(table.at(c)[q], value(i, j, k) + q);
      ++c;
    });
  };
  const auto make = [](Numbers& n, const Layout& c, const Layout& m, int r) {
    n.of_cells.reset(c.cells(r), 3), n.of_nodes.reset(m.cells(r), 2);
  };
  make(given, cells, nodes, rank);
  each(given.of_cells, [](double& x, double v) { x = v; }), each(given.of_nodes, [](double& x, double v) { x = v; });
  {
    Hdf5File file(comm, path, Hdf5File::Mode::kCreate, 1e6);
    StateFile(comm, cells, nodes, file).write("/state", given);
    file.close();
  }
  const auto check = [&](MPI_Comm readers, double own, double alike) {
    const int n = ranks_of(readers);
    const Layout c = make_layout(grid, n, {2, 2, 2}), m = node_layout(c, coarse);
    Numbers got;
    got.unused.reset({{0, 0, 0}, {1, 1, 1}});
    make(got, c, m, rank_of(readers));
    Hdf5File file(readers, path, Hdf5File::Mode::kRead, 0);
    StateFile(readers, c, m, file).read("/state", got);
    file.close();
    EXPECT_DOUBLE_EQ(got.own, own);
    EXPECT_EQ(got.alike, alike);  // a sum is one even where its parts are equal
    EXPECT_EQ(got.same, 1.0 / 3);
    EXPECT_EQ(got.whole, -7);
    EXPECT_TRUE(got.flag);
    EXPECT_EQ(got.unused.size(), 0u);
    const int r = rank_of(readers);
    EXPECT_TRUE(got.cells.box() == c.cells(r).grown(2));
    EXPECT_TRUE(got.nodes.box() == m.cells(r));
    long long wrong = 0;
    for (Array3<double>* a : {static_cast<Array3<double>*>(&got.cells), static_cast<Array3<double>*>(&got.nodes)})
      for_each(a->box(), [&](int i, int j, int k) { wrong += (*a)(i, j, k) != value(i, j, k); });
    each(got.of_cells, [&](double x, double v) { wrong += x != v; });
    each(got.of_nodes, [&](double x, double v) { wrong += x != v; });
    EXPECT_EQ(wrong, 0);
  };
  check(comm, rank + 0.1, 0.25);
  double sum = 0;
  for (int r = 0; r < ranks; ++r) sum += r + 0.1;
  check(MPI_COMM_SELF, sum, 0.25 * ranks);
  MPI_Barrier(comm);
  if (rank == 0) unlink(path.c_str());
}

}  // namespace
}  // namespace twogrid_test
