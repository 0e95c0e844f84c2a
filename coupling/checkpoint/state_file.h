// A state's entries (for_each_entry() of FluidState, CouplingState, ScheduleState) in an HDF5 file, each by its name. The
// file doesn't know the ranks that wrote it: an array is that of the whole grid, with what lies beyond the sides that are
// not periodic, and every rank reads its part and its halo from it; a table (CellTable) is that of
// all own cells. A number has a value a rank; of those that
// wrote, other ranks get the first one's, and of a number whose name ends with _of_rank, rank 0 gets the sum, and the
// others nothing. A list is the same on all ranks, and as long when it is read as when it was written.
//
// For tests: with TWOGRID_CHECKPOINT_LEAVE_OUT=group/entry in the environment reading passes that entry over, which keeps
// what a new process has. A test can so show that it is needed.
#pragma once

#include <mpi.h>

#include <cmath>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "cfd/grid/cell_table.h"
#include "cfd/grid/field.h"
#include "cfd/grid/layout.h"
#include "coupling/output/hdf5_file.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

/// Whether a test wants this path ("/group/entry") to be passed over.
bool left_out(const std::string& path);

/// Numbers that someone else keeps, as a state: what checkpoint.h need not know by type.
struct NumberList {
  using Number = std::variant<double*, long long*, int*, bool*>;
  std::string group;
  std::vector<std::pair<std::string, Number>> numbers;
  bool of_script = false;  ///< of what the script has, which may have more than the one that wrote

  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    for (auto& entry : s.numbers) std::visit([&](auto* value) { f(entry.first, *value); }, entry.second);
  }
};

/// The entries of a state of numbers, which must outlive the list.
template <class State>
NumberList numbers_of(const std::string& group, State& state) {
  NumberList list{group, {}};
  State::for_each_entry(state, [&](const std::string& name, auto& number) { list.numbers.push_back({name, &number}); });
  return list;
}

class StateFile {
 public:
  /// cells, nodes: of the fluid and of the particle grid.
  StateFile(MPI_Comm comm, const Layout& cells, const Layout& nodes, Hdf5File& file);

  /// Arrays that are not in use (size 0) are left out. Collective.
  template <class State>
  void write(const std::string& group, const State& state) {
    file_.group(group);
    State::for_each_entry(state, [&](const std::string& name, const auto& entry) {
      using T = std::decay_t<decltype(entry)>;
      const std::string path = group + "/" + name;
      if constexpr (std::is_arithmetic_v<T>)
        write_number(path, double(entry));
      else if constexpr (std::is_same_v<T, std::vector<double>>)
        file_.replicated(path, entry, {entry.size()});
      else
        write_entry(path, entry, layout_of(entry));
    });
  }
  /// Arrays that the file lacks become empty. Collective; numbers that are missing, and what can be no state, are told by
  /// the file's close().
  template <class State>
  void read(const std::string& group, State& state) {
    State::for_each_entry(state, [&](const std::string& name, auto& entry) {
      using T = std::decay_t<decltype(entry)>;
      const std::string path = group + "/" + name;
      if (left_out(path)) return;
      if constexpr (std::is_same_v<std::decay_t<State>, NumberList>)
        if (state.of_script && !file_.has(path)) return;
      if constexpr (std::is_arithmetic_v<T>)
        entry = number_as<T>(path);
      else if constexpr (std::is_same_v<T, std::vector<double>>)
        read_list(path, entry);
      else
        read_entry(path, entry, layout_of(entry));
    });
  }

 private:
  const Layout& layout_of(const CellField<ParticleGrid>&) const { return nodes_; }
  const Layout& layout_of(const CellField<FineGrid>&) const { return cells_; }
  const Layout& layout_of(const FaceComponent<FineGrid>&) const { return cells_; }
  const Layout& layout_of(const CellTable<ParticleGrid>&) const { return nodes_; }
  const Layout& layout_of(const CellTable<FineGrid>&) const { return cells_; }
  void write_entry(const std::string& path, const Array3<double>& a, const Layout& l) { write_array(path, a, l); }
  void read_entry(const std::string& path, Array3<double>& a, const Layout& l) { read_array(path, a, l); }
  template <class G>
  void write_entry(const std::string& path, const CellTable<G>& t, const Layout& l) {
    file_.slab(path, table_slab(t.own(), t.columns(), l), t.data());
  }
  template <class G>
  void read_entry(const std::string& path, CellTable<G>& t, const Layout& l) {
    file_.read(path, table_slab(t.own(), t.columns(), l), t.data());
    check(path, t.data(), t.size());
  }
  /// As the type of an entry: a number that it can hold, or it is a failure.
  template <class T>
  T number_as(const std::string& path) {
    const double value = read_number(path);
    const bool fits = !std::is_integral_v<T> ||
                      (value == std::floor(value) && value >= least_of<T>() && std::abs(value) <= most_of<T>());
    if (check(path, &value, 1) && fits) return T(value);
    if (!fits) file_.unfit(path + " is no such whole number: " + std::to_string(value));
    return T();
  }
  template <class T>
  static constexpr double least_of() {
    return std::is_same_v<T, bool> ? 0 : std::is_same_v<T, int> ? -2147483648.0 : -9007199254740992.0;
  }
  template <class T>
  static constexpr double most_of() {
    return std::is_same_v<T, long long> ? 9007199254740992.0 : 2147483647.0 /* a sum of flags, too */;
  }
  /// Whether all lie in their range (state_check.h); else it is a failure.
  bool check(const std::string& path, const double* value, std::size_t count);
  Slab table_slab(const Box& own, int columns, const Layout& layout) const;
  void write_number(const std::string& path, double value);
  double read_number(const std::string& path);
  void read_list(const std::string& path, std::vector<double>& list);
  void write_array(const std::string& path, const Array3<double>& a, const Layout& layout);
  void read_array(const std::string& path, Array3<double>& a, const Layout& layout);

  MPI_Comm comm_;
  int rank_, ranks_;
  const Layout& cells_;
  const Layout& nodes_;
  Hdf5File& file_;
};

}  // namespace twogrid
