#include "coupling/output/held_writes.h"

#include <fcntl.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "coupling/output/hdf5_tools.h"
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

namespace twogrid {

namespace {

constexpr unsigned long long kAll = ~0ULL;

bool write_all(int f, const char* bytes, std::size_t count, off_t at) {
  while (count > 0) {
    const ssize_t n = pwrite(f, bytes, count, at);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes += n, count -= std::size_t(n), at += n;
  }
  return true;
}

/// Order of commit: the file's length and then names first, which nothing names yet; then the tables from the top down. A
/// table that HDF5 has split is met by its parent before its second half is taken out of it. A group's names and what tells
/// of the room among them must not be parted: they are one write as long as the names have the room they were made with.
int turn(unsigned long long at, const std::string& bytes) {
  if (at == 0) return 0;
  if (bytes.compare(0, 4, "HEAP") == 0) return 1;
  if (bytes.compare(0, 4, "TREE") == 0) return 3;
  if (bytes.compare(0, 4, "SNOD") == 0) return 4;
  return 2;
}

}  // namespace

int HeldWrites::killed_after = -1;
int HeldWrites::writes = 0;

struct HeldWrites::Driver {
  H5FD_t head;  // HDF5's; must be the first
  int file;
  HeldWrites* held;
  haddr_t end;

  static Driver* of(H5FD_t* f) { return reinterpret_cast<Driver*>(f); }
  static const Driver* of(const H5FD_t* f) { return reinterpret_cast<const Driver*>(f); }

  static H5FD_t* open(const char* name, unsigned flags, hid_t fapl, haddr_t) {
    const bool writes = flags & H5F_ACC_RDWR;
    int how = O_CLOEXEC | (writes ? O_RDWR : O_RDONLY);
    if (flags & H5F_ACC_CREAT) how |= O_CREAT;
    if (flags & H5F_ACC_TRUNC) how |= O_TRUNC;
    const int file = ::open(name, how, 0666);
    if (file < 0) return nullptr;
    const void* info = H5Pget_driver_info(fapl);
    Driver* d = new Driver();
    d->file = file;
    if (info) std::memcpy(&d->held, info, sizeof d->held);  // NOLINT(bugprone-sizeof-expression): a pointer is meant
    return &d->head;
  }
  static herr_t close(H5FD_t* f) {
    Driver* d = of(f);
    const int done = ::close(d->file);
    delete d;
    return done == 0 ? 0 : -1;
  }
  static herr_t query(const H5FD_t*, unsigned long* flags) {
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
  }
  static haddr_t get_eoa(const H5FD_t* f, H5FD_mem_t) { return of(f)->end; }
  static herr_t set_eoa(H5FD_t* f, H5FD_mem_t, haddr_t end) {
    Driver* d = of(f);
    d->end = end;
    if (d->held) d->held->size_ = end;
    return 0;
  }
  static haddr_t get_eof(const H5FD_t* f, H5FD_mem_t) {
    struct stat s;
    return fstat(of(f)->file, &s) == 0 ? haddr_t(s.st_size) : HADDR_UNDEF;
  }
  static herr_t read(H5FD_t* f, H5FD_mem_t, hid_t, haddr_t at, size_t count, void* to) {
    const Driver* d = of(f);
    char* bytes = static_cast<char*>(to);
    std::size_t done = 0;
    while (done < count) {
      const ssize_t n = pread(d->file, bytes + done, count - done, off_t(at + done));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return -1;
      if (n == 0) break;
      done += std::size_t(n);
    }
    std::memset(bytes + done, 0, count - done);
    if (d->held) d->held->show(at, bytes, count);
    return 0;
  }
  static herr_t write(H5FD_t* f, H5FD_mem_t, hid_t, haddr_t at, size_t count, const void* from) {
    Driver* d = of(f);
    const char* bytes = static_cast<const char*>(from);
    const std::size_t below = !d->held || at >= d->held->end_ ? 0 : std::min<haddr_t>(count, d->held->end_ - at);
    if (below > 0) d->held->hold(at, bytes, below);
    return write_all(d->file, bytes + below, count - below, off_t(at + below)) ? 0 : -1;
  }

  static hid_t registered() {
    static const H5FD_class_t kClass = [] {
      H5FD_class_t c;
      std::memset(&c, 0, sizeof c);
#if H5_VERSION_GE(1, 13, 0)
      c.version = H5FD_CLASS_VERSION;
      c.value = H5FD_class_value_t(600);
#endif
      c.name = "twogrid";
      c.maxaddr = (haddr_t(1) << (8 * sizeof(off_t) - 1)) - 1;
      c.fc_degree = H5F_CLOSE_STRONG;
      c.fapl_size = sizeof(HeldWrites*);  // NOLINT(bugprone-sizeof-expression): a pointer is meant
      c.open = open, c.close = close, c.query = query;
      c.get_eoa = get_eoa, c.set_eoa = set_eoa, c.get_eof = get_eof;
      c.read = read, c.write = write;
      const H5FD_mem_t map[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
      std::memcpy(c.fl_map, map, sizeof map);
      return c;
    }();
    static const hid_t kId = H5FDregister(&kClass);
    return kId;
  }
};

long HeldWrites::open(const std::string& path, bool create) {
  path_ = path;
  held_.clear();
  end_ = create ? 0 : kAll;
  HeldWrites* const self = this;
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_driver(access, Driver::registered(), &self);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  const hid_t file = create ? H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access)
                            : H5Fopen(path.c_str(), H5F_ACC_RDWR, access);
  if (file >= 0 && !create) end_ = size_;
  return file;
}

long HeldWrites::open_to_read(const std::string& path) {
  HeldWrites* const none = nullptr;
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_driver(access, Driver::registered(), &none);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  return H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
}

void HeldWrites::hold(unsigned long long at, const char* bytes, std::size_t count) {
  unsigned long long lo = at, hi = at + count;
  auto first = held_.upper_bound(at);
  if (first != held_.begin() && std::prev(first)->first + std::prev(first)->second.size() >= at) --first;
  auto last = first;
  for (; last != held_.end() && last->first <= at + count; ++last)
    lo = std::min(lo, last->first), hi = std::max<unsigned long long>(hi, last->first + last->second.size());
  std::string joint(hi - lo, '\0');
  for (auto h = first; h != last; ++h) joint.replace(h->first - lo, h->second.size(), h->second);
  joint.replace(at - lo, count, bytes, count);
  held_.erase(first, last);
  held_[lo] = std::move(joint);
}

void HeldWrites::show(unsigned long long at, char* bytes, std::size_t count) const {
  auto h = held_.upper_bound(at);
  if (h != held_.begin()) --h;
  for (; h != held_.end() && h->first < at + count; ++h) {
    const unsigned long long lo = std::max(at, h->first), hi = std::min(at + count, h->first + h->second.size());
    if (lo < hi) std::memcpy(bytes + (lo - at), h->second.data() + (lo - h->first), hi - lo);
  }
}

std::string HeldWrites::commit() {
  const int f = ::open(path_.c_str(), O_RDWR | O_CLOEXEC);
  if (f < 0) return std::strerror(errno);
  std::vector<std::pair<unsigned long long, std::string>> all(held_.begin(), held_.end());
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return turn(a.first, a.second) < turn(b.first, b.second); });
  // The file may not be shorter than it says.
  struct stat s;
  bool good = fstat(f, &s) == 0 && ((unsigned long long)(s.st_size) >= size_ || ftruncate(f, off_t(size_)) == 0);
  int left = killed_after < 0 ? int(all.size()) : killed_after;
  for (const auto& [at, bytes] : all)
    if (left-- > 0) good = good && write_all(f, bytes.data(), bytes.size(), off_t(at));
  if (killed_after < 0) good = good && ftruncate(f, off_t(size_)) == 0;
  std::string why = good ? "" : std::strerror(errno);
  ::close(f);
  held_.clear();
  HeldWrites::writes = int(all.size());
  return why;
}

}  // namespace twogrid
