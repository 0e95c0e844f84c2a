#include "coupling/checkpoint/state_file.h"

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "cfd/parallel/ranks.h"
#include "coupling/checkpoint/state_check.h"

namespace twogrid {

namespace {

constexpr int kMostBeyond = 1000;  // cells of a halo

/// Part of the array `a` in a dataset whose first value is that of index `first`.
Slab slab_of(const Box& part, const Int3& first, const std::vector<std::size_t>& extent, const Box& a) {
  Slab s;
  s.extent = extent;
  for (int d = 2; d >= 0; --d) {
    s.offset.push_back(part.empty() ? 0 : part.lo[d] - first[d]);
    s.count.push_back(part.empty() ? 0 : part.size(d));
    s.memory_extent.push_back(a.size(d));
    s.memory_offset.push_back(part.empty() ? 0 : part.lo[d] - a.lo[d]);
  }
  return s;
}

}  // namespace

bool left_out(const std::string& path) {
  static const char* const named = std::getenv("TWOGRID_CHECKPOINT_LEAVE_OUT");
  return named && path == std::string("/") + named;
}

StateFile::StateFile(MPI_Comm comm, const Layout& cells, const Layout& nodes, Hdf5File& file)
    : comm_(comm), rank_(rank_of(comm)), ranks_(ranks_of(comm)), cells_(cells), nodes_(nodes), file_(file) {}

Slab StateFile::table_slab(const Box& own, int columns, const Layout& layout) const {
  Slab s;
  for (int d = 2; d >= 0; --d) {
    s.extent.push_back(std::size_t(layout.extent()[d]));
    s.offset.push_back(own.empty() ? 0 : own.lo[d]);
    s.count.push_back(own.empty() ? 0 : own.size(d));
  }
  s.extent.push_back(std::size_t(columns)), s.offset.push_back(0), s.count.push_back(std::size_t(columns));
  return s;
}

void StateFile::write_number(const std::string& path, double value) {
  Slab s;
  s.extent = {std::size_t(ranks_)}, s.offset = {std::size_t(rank_)}, s.count = {1};
  file_.slab(path, s, &value);
}

double StateFile::read_number(const std::string& path) {
  const std::vector<double> all = file_.whole(path);
  if (all.empty()) return file_.unfit(path + " is not there, or of another kind"), 0;
  if (int(all.size()) == ranks_) return all[rank_];
  static const std::string kPart = "_of_rank";
  if (path.size() < kPart.size() || path.compare(path.size() - kPart.size(), kPart.size(), kPart) != 0) return all[0];
  double sum = 0;
  for (double v : all) sum += v;
  return rank_ == 0 ? sum : 0;
}

void StateFile::read_list(const std::string& path, std::vector<double>& list) {
  std::vector<double> all = file_.whole(path);
  if (all.size() != list.size())
    return file_.unfit(path + " is not there, or has not " + std::to_string(list.size()) + " entries");
  if (check(path, all.data(), all.size())) list.swap(all);
}

void StateFile::write_array(const std::string& path, const Array3<double>& a, const Layout& layout) {
  const Box own = layout.cells(rank_), box = a.box();
  const bool here = a.size() > 0 && !own.empty();
  // Widths beyond own cells, and those beyond the grid's sides.
  int most[12] = {};
  for (int d = 0; d < 3 && here; ++d) {
    most[d] = own.lo[d] - box.lo[d], most[3 + d] = box.hi[d] - own.hi[d];
    if (layout.periodic()[d]) continue;
    if (own.lo[d] == 0) most[6 + d] = -box.lo[d];
    if (own.hi[d] == layout.extent()[d]) most[9 + d] = box.hi[d] - layout.extent()[d];
  }
  int in_use = here;
  MPI_Allreduce(MPI_IN_PLACE, &in_use, 1, MPI_INT, MPI_MAX, comm_);
  if (!in_use) return;
  MPI_Allreduce(MPI_IN_PLACE, most, 12, MPI_INT, MPI_MAX, comm_);
  Box part = own;
  Int3 first;
  std::vector<std::size_t> extent;
  for (int d = 2; d >= 0; --d) extent.push_back(layout.extent()[d] + most[6 + d] + most[9 + d]);
  for (int d = 0; d < 3; ++d) {
    first[d] = -most[6 + d];
    if (layout.periodic()[d]) continue;
    if (own.lo[d] == 0) part.lo[d] = first[d];
    if (own.hi[d] == layout.extent()[d]) part.hi[d] = layout.extent()[d] + most[9 + d];
  }
  file_.slab(path, slab_of(here ? part : Box{}, first, extent, box), a.data());
  file_.attribute(path, "widths", std::vector<int>(most, most + 12));
}

void StateFile::read_array(const std::string& path, Array3<double>& a, const Layout& layout) {
  if (!file_.has(path)) {
    a.reset(Box{});
    return;
  }
  const std::vector<int> w = file_.whole_attribute(path, "widths");
  const std::vector<std::size_t> extent = file_.extent(path);
  bool fits = w.size() == 12 && extent.size() == 3;
  for (int d = 0; d < 3 && fits; ++d)
    fits = std::size_t(layout.extent()[d]) + std::size_t(w[6 + d]) + std::size_t(w[9 + d]) == extent[2 - d];
  if (!fits || std::any_of(w.begin(), w.end(), [](int cells) { return cells < 0 || cells > kMostBeyond; }))
    return file_.unfit(path + " is of another size");
  const Box own = layout.cells(rank_);
  if (own.empty()) return;
  if (a.size() == 0)
    a.reset({{own.lo[0] - w[0], own.lo[1] - w[1], own.lo[2] - w[2]},
             {own.hi[0] + w[3], own.hi[1] + w[4], own.hi[2] + w[5]}});
  const Int3 first{-w[6], -w[7], -w[8]}, n = layout.extent();
  // The box in pieces: one a period, beside the one inside.
  Int3 periods;
  for (int d = 0; d < 3; ++d) periods[d] = layout.periodic()[d] ? a.box().size(d) / n[d] + 1 : 0;
  for (int z = -periods[2]; z <= periods[2]; ++z)
    for (int y = -periods[1]; y <= periods[1]; ++y)
      for (int x = -periods[0]; x <= periods[0]; ++x) {
        const Int3 shift{x * n[0], y * n[1], z * n[2]};
        Box whole;  // of the dataset
        for (int d = 0; d < 3; ++d) whole.lo[d] = first[d], whole.hi[d] = first[d] + int(extent[2 - d]);
        const Box part = intersect(a.box(), whole.shifted(shift));
        if (part.empty()) continue;
        file_.read(path,
                   slab_of(part, {first[0] + shift[0], first[1] + shift[1], first[2] + shift[2]}, extent, a.box()),
                   a.data());
      }
  check(path, a.data(), a.size());
}

bool StateFile::check(const std::string& path, const double* value, std::size_t count) {
  const EntryRange range = range_of(path);
  const double* const wrong = std::find_if(value, value + count, [&](double v) { return !range.holds(v); });
  if (wrong == value + count) return true;
  std::ostringstream found;
  found << path << " holds " << *wrong << ", wanted " << range.least << " to " << range.most;
  file_.unfit(found.str());
  return false;
}

}  // namespace twogrid
