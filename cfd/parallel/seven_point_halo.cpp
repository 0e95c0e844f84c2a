#include "cfd/parallel/seven_point_halo.h"

#include <algorithm>

#include "cfd/parallel/ranks.h"

namespace twogrid {

namespace {

constexpr int kTag = 4712;

/// Memory index of a cell in an array over the box b.
int memory_index(const Box& b, const Int3& c) {
  return c[0] - b.lo[0] + b.size(0) * (c[1] - b.lo[1] + b.size(1) * (c[2] - b.lo[2]));
}

/// The layer of cells just outside side s (xlo xhi ylo yhi zlo zhi) of a box.
Box layer_outside(const Box& own, int s) {
  Box b = own;
  const int d = s / 2;
  if (s % 2 == 0)
    b.hi[d] = own.lo[d], b.lo[d] = own.lo[d] - 1;
  else
    b.lo[d] = own.hi[d], b.hi[d] = own.hi[d] + 1;
  return b;
}

}  // namespace

SevenPointHalo::SevenPointHalo(MPI_Comm comm, const std::vector<Box>& owned, const Int3& n,
                               const std::array<bool, 3>& periodic, const Int3& width)
    : comm_(comm) {
  const int me = rank_of(comm);
  const Box &mine = owned[me], memory = mine.grown(width);
  // Calls f(owner's cell, cell in the halo) for all cells that `owner` gives to the halo of `seer`, in one fixed order.
  auto shared = [&](const Box& owner, const Box& seer, auto&& f) {
    if (owner.empty() || seer.empty()) return;
    for (int s = 0; s < 6; ++s) {
      const int d = s / 2;
      const Box layer = layer_outside(seer, s);
      Int3 shift{0, 0, 0};
      if (periodic[d] && layer.lo[d] < 0) shift[d] = n[d];
      if (periodic[d] && layer.lo[d] >= n[d]) shift[d] = -n[d];
      for_each(intersect(owner, layer.shifted(shift)), [&](int i, int j, int k) {
        f(Int3{i, j, k}, Int3{i - shift[0], j - shift[1], k - shift[2]});
      });
    }
  };
  auto red = [](const Int3& c) { return ((c[0] + c[1] + c[2]) & 1) == 0; };
  for (int r = 0; r < int(owned.size()); ++r) {
    Peer p;
    p.rank = r;
    for (bool want_red : {true, false}) {
      shared(mine, owned[r], [&](const Int3& own, const Int3&) {
        if (red(own) == want_red) p.give.push_back(memory_index(memory, own));
      });
      shared(owned[r], mine, [&](const Int3& own, const Int3& image) {
        if (red(own) == want_red) p.take.push_back(memory_index(memory, image));
      });
      if (want_red) p.give_red = int(p.give.size()), p.take_red = int(p.take.size());
    }
    if (r == me) {
      self_ = std::move(p);
    } else if (!p.give.empty() || !p.take.empty()) {
      const std::size_t bytes = sizeof(double) * kMaxArrays * std::max(p.give.size(), p.take.size());
      p.out.resize(bytes);
      p.in.resize(bytes);
      peers_.push_back(std::move(p));
    }
  }
  requests_.resize(2 * peers_.size());
}

template <class T>
void SevenPointHalo::bring(std::initializer_list<Array3<T>*> arrays, Cells cells) {
  const std::size_t np = peers_.size(), fields = arrays.size();
  for (std::size_t p = 0; p < np; ++p) {
    Peer& q = peers_[p];
    const Range r = range(q.take_red, int(q.take.size()), cells);
    MPI_Irecv(q.in.data(), int(sizeof(T) * fields * (r.end - r.begin)), MPI_BYTE, q.rank, kTag, comm_, &requests_[p]);
  }
  for (std::size_t p = 0; p < np; ++p) {
    Peer& q = peers_[p];
    const Range r = range(q.give_red, int(q.give.size()), cells);
    T* out = reinterpret_cast<T*>(q.out.data());
    for (const Array3<T>* a : arrays)
      for (int m = r.begin; m < r.end; ++m) *out++ = a->data()[q.give[m]];
    MPI_Isend(q.out.data(), int(sizeof(T) * fields * (r.end - r.begin)), MPI_BYTE, q.rank, kTag, comm_,
              &requests_[np + p]);
  }
  const Range own = range(self_.give_red, int(self_.give.size()), cells);
  for (Array3<T>* a : arrays)
    for (int m = own.begin; m < own.end; ++m) a->data()[self_.take[m]] = a->data()[self_.give[m]];
  for (std::size_t p = 0; p < np; ++p) {
    Peer& q = peers_[p];
    const Range r = range(q.take_red, int(q.take.size()), cells);
    MPI_Wait(&requests_[p], MPI_STATUS_IGNORE);
    const T* in = reinterpret_cast<const T*>(q.in.data());
    for (Array3<T>* a : arrays)
      for (int m = r.begin; m < r.end; ++m) a->data()[q.take[m]] = *in++;
  }
  MPI_Waitall(int(np), requests_.data() + np, MPI_STATUSES_IGNORE);
}

template <class T>
void SevenPointHalo::add(Array3<T>& array) {
  const std::size_t np = peers_.size();
  T* a = array.data();
  for (std::size_t p = 0; p < np; ++p) {
    Peer& q = peers_[p];
    MPI_Irecv(q.in.data(), int(sizeof(T) * q.give.size()), MPI_BYTE, q.rank, kTag, comm_, &requests_[p]);
  }
  for (std::size_t p = 0; p < np; ++p) {
    Peer& q = peers_[p];
    T* out = reinterpret_cast<T*>(q.out.data());
    for (int m : q.take) *out++ = a[m];
    MPI_Isend(q.out.data(), int(sizeof(T) * q.take.size()), MPI_BYTE, q.rank, kTag, comm_, &requests_[np + p]);
  }
  for (std::size_t m = 0; m < self_.give.size(); ++m) a[self_.give[m]] += a[self_.take[m]];
  for (std::size_t p = 0; p < np; ++p) {
    Peer& q = peers_[p];
    MPI_Wait(&requests_[p], MPI_STATUS_IGNORE);
    const T* in = reinterpret_cast<const T*>(q.in.data());
    for (int m : q.give) a[m] += *in++;
  }
  MPI_Waitall(int(np), requests_.data() + np, MPI_STATUSES_IGNORE);
}

template void SevenPointHalo::bring<double>(std::initializer_list<Array3<double>*>, Cells);
template void SevenPointHalo::bring<float>(std::initializer_list<Array3<float>*>, Cells);
template void SevenPointHalo::add<double>(Array3<double>&);
template void SevenPointHalo::add<float>(Array3<float>&);

}  // namespace twogrid
