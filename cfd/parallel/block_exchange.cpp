#include "cfd/parallel/block_exchange.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "cfd/parallel/ranks.h"

namespace twogrid {

namespace {

int floor_div(int a, int b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

/// Values are doubles or 64-bit integers, or groups of them.
template <class T>
MPI_Datatype mpi_type() {
  return std::is_same_v<T, double> || std::is_same_v<T, FourNumbers> ? MPI_DOUBLE : MPI_INT64_T;
}
template <class T>
int mpi_count(std::size_t n) {
  static_assert(sizeof(T) % 8 == 0, "whole numbers of 8 bytes");
  return int(n * (sizeof(T) / 8));
}

/// Rows of a halo are short, down to one value: a call of memcpy would cost more than they do.
template <class T>
inline void copy_row(const T* from, T* to, int n) {
  switch (n) {
    case 4:
      to[3] = from[3];
      [[fallthrough]];
    case 3:
      to[2] = from[2];
      [[fallthrough]];
    case 2:
      to[1] = from[1];
      [[fallthrough]];
    case 1:
      to[0] = from[0];
      [[fallthrough]];
    case 0:
      return;
    default:
      std::memcpy(to, from, n * sizeof(T));
  }
}

template <class T>
inline void unpack_row(T* row, const T* in, int n, bool accumulate) {
  if (accumulate)
    for (int i = 0; i < n; ++i) row[i] += in[i];
  else
    copy_row(in, row, n);
}

template <class T>
void pack(const Array3<T>* a, const Box& b, T*& out) {
  const int n = b.size(0);
  const std::ptrdiff_t row = a->stride(1), slab = a->stride(2);
  const T* from_slab = a->data() + a->index(b.lo[0], b.lo[1], b.lo[2]);
  for (int k = b.lo[2]; k < b.hi[2]; ++k, from_slab += slab) {
    const T* from = from_slab;
    for (int j = b.lo[1]; j < b.hi[1]; ++j, out += n, from += row) copy_row(from, out, n);
  }
}

template <class T>
void unpack(Array3<T>* a, const Box& b, const T*& in, bool accumulate) {
  const int n = b.size(0);
  const std::ptrdiff_t row = a->stride(1), slab = a->stride(2);
  T* to_slab = a->data() + a->index(b.lo[0], b.lo[1], b.lo[2]);
  for (int k = b.lo[2]; k < b.hi[2]; ++k, to_slab += slab) {
    T* to = to_slab;
    for (int j = b.lo[1]; j < b.hi[1]; ++j, in += n, to += row) unpack_row(to, in, n, accumulate);
  }
}

template <class T>
void pack(const Slot<T>& a, const Box& b, T*& out) {
  const int n = b.size(0);
  for (int k = b.lo[2]; k < b.hi[2]; ++k)
    for (int j = b.lo[1]; j < b.hi[1]; ++j) {
      const T* from = a.data + a.stride * a.index(b.lo[0], j, k);
      for (int i = 0; i < n; ++i, from += a.stride) *out++ = *from;
    }
}

template <class T>
void unpack(const Slot<T>& a, const Box& b, const T*& in, bool accumulate) {
  const int n = b.size(0);
  for (int k = b.lo[2]; k < b.hi[2]; ++k)
    for (int j = b.lo[1]; j < b.hi[1]; ++j) {
      T* to = a.data + a.stride * a.index(b.lo[0], j, k);
      if (accumulate)
        for (int i = 0; i < n; ++i, to += a.stride) *to += *in++;
      else
        for (int i = 0; i < n; ++i, to += a.stride) *to = *in++;
    }
}

template <class T>
T* row_of(const Slot<T>& a, int i, int j, int k) {
  return a.data + a.stride * a.index(i, j, k);
}
template <class T>
T* row_of(Array3<T>* a, int i, int j, int k) {
  return a->data() + a->index(i, j, k);
}
template <class T>
const T* row_of(const Array3<T>* a, int i, int j, int k) {
  return a->data() + a->index(i, j, k);
}
template <class T>
int stride_of(const Slot<T>& a) {
  return a.stride;
}
template <class T>
int stride_of(const Array3<T>*) {
  return 1;
}

/// The same without a buffer between; the boxes are of one size and don't overlap in one array.
template <class Source, class Target>
void carry_over(const Source& from, const Box& b, const Target& to, const Box& at, bool accumulate) {
  const int n = b.size(0), in = stride_of(from), out = stride_of(to);
  for (int k = 0; k < b.size(2); ++k)
    for (int j = 0; j < b.size(1); ++j) {
      auto* const target = row_of(to, at.lo[0], at.lo[1] + j, at.lo[2] + k);
      const auto* const source = row_of(from, b.lo[0], b.lo[1] + j, b.lo[2] + k);
      if (in == 1 && out == 1)
        unpack_row(target, source, n, accumulate);
      else if (accumulate)
        for (int i = 0; i < n; ++i) target[out * i] += source[in * i];
      else
        for (int i = 0; i < n; ++i) target[out * i] = source[in * i];
    }
}

/// Room for the values of all fields, one peer after the other.
template <class T, class Peers>
T* make_room(const Peers& peers, std::size_t fields, std::vector<FourNumbers>& buffer) {
  std::size_t values = 0;
  for (const auto& p : peers) values += p.count * fields;
  const std::size_t groups = (values * sizeof(T) + sizeof(FourNumbers) - 1) / sizeof(FourNumbers);
  if (buffer.size() < groups) buffer.resize(groups);
  return reinterpret_cast<T*>(buffer.data());
}

}  // namespace

BlockExchange::BlockExchange(MPI_Comm comm, const std::vector<Box>& owned, const std::vector<Box>& wanted,
                             const Int3& period, const std::array<bool, 3>& periodic)
    : comm_(comm) {
  rank_ = rank_of(comm);
  const int ranks = int(owned.size());
  // Pieces of `want` that the owner of `own` holds: one per periodic image.
  auto pieces = [&](const Box& own, const Box& want) {
    std::vector<Piece> found;
    if (own.empty() || want.empty()) return found;
    Int3 first{0, 0, 0}, last{0, 0, 0};
    for (int d = 0; d < 3; ++d)
      if (periodic[d]) {
        first[d] = floor_div(want.lo[d] - own.hi[d] + 1, period[d]);
        last[d] = floor_div(want.hi[d] - 1 - own.lo[d], period[d]);
      }
    for (int c = first[2]; c <= last[2]; ++c)
      for (int b = first[1]; b <= last[1]; ++b)
        for (int a = first[0]; a <= last[0]; ++a) {
          const Int3 shift{a * period[0], b * period[1], c * period[2]};
          const Box hit = intersect(own, want.shifted({-shift[0], -shift[1], -shift[2]}));
          if (!hit.empty()) found.push_back({hit, shift});
        }
    return found;
  };
  auto count = [](const std::vector<Piece>& p) {
    std::size_t n = 0;
    for (const Piece& x : p) n += x.owner.count();
    return n;
  };
  for (int r = 0; r < ranks; ++r) {
    if (r == rank_) {
      self_ = pieces(owned[r], wanted[r]);
      continue;
    }
    auto give = pieces(owned[rank_], wanted[r]);
    if (!give.empty()) send_.push_back({r, give, count(give)});
    auto take = pieces(owned[r], wanted[rank_]);
    if (!take.empty()) receive_.push_back({r, take, count(take)});
  }
}

template <class T, class Source, class Target>
void BlockExchange::transfer(const std::vector<Peer>& from, const std::vector<Peer>& to,
                             const std::vector<Source>& source, const std::vector<Target>& target, bool to_window,
                             bool accumulate, bool in_place) const {
  // `to` peers get what they want out of `source`; `from` peers' values arrive in `target`. Peers are in rank order,
  // so that sums don't depend on the order of arrival.
  const std::size_t fields = source.size();
  request_.resize(to.size() + from.size());
  constexpr int tag = 4711;
  T* const in = make_room<T>(from, fields, in_);
  T* at = in;
  for (std::size_t p = 0; p < from.size(); at += from[p++].count * fields)
    MPI_Irecv(at, mpi_count<T>(from[p].count * fields), mpi_type<T>(), from[p].rank, tag, comm_, &request_[p]);
  auto window_box = [](const Piece& q) { return q.owner.shifted(q.shift); };
  T* out = make_room<T>(to, fields, out_);
  for (std::size_t p = 0; p < to.size(); ++p) {
    T* const first = out;
    for (const Source& a : source)
      for (const Piece& q : to[p].pieces) pack(a, to_window ? q.owner : window_box(q), out);
    MPI_Isend(first, mpi_count<T>(to[p].count * fields), mpi_type<T>(), to[p].rank, tag, comm_,
              &request_[from.size() + p]);
  }
  auto own_pieces = [&] {
    for (std::size_t a = 0; a < fields; ++a)
      for (const Piece& q : self_) {
        if (in_place && q.shift == Int3{0, 0, 0}) continue;
        const Box window = window_box(q);
        carry_over(source[a], to_window ? q.owner : window, target[a], to_window ? window : q.owner, accumulate);
      }
  };
  const T* arrived = in;
  bool own_done = false;
  for (std::size_t p = 0; p < from.size(); ++p) {
    if (!own_done && from[p].rank > rank_) own_pieces(), own_done = true;
    MPI_Wait(&request_[p], MPI_STATUS_IGNORE);
    for (const Target& a : target)
      for (const Piece& q : from[p].pieces) unpack(a, to_window ? window_box(q) : q.owner, arrived, accumulate);
  }
  if (!own_done) own_pieces();
  MPI_Waitall(int(to.size()), request_.data() + from.size(), MPI_STATUSES_IGNORE);
}

template <class T>
void BlockExchange::bring(const std::vector<const Array3<T>*>& owner, const std::vector<Array3<T>*>& window) const {
  transfer<T>(receive_, send_, owner, window, true, false, false);
}

template <class T>
void BlockExchange::bring(const std::vector<Slot<T>>& owner, const std::vector<Slot<T>>& window) const {
  transfer<T>(receive_, send_, owner, window, true, false, owner[0].data == window[0].data);
}

template <class T>
void BlockExchange::add(const std::vector<const Array3<T>*>& window, const std::vector<Array3<T>*>& owner) const {
  transfer<T>(send_, receive_, window, owner, false, true, false);
}

template <class T>
void BlockExchange::add(const std::vector<Slot<T>>& window, const std::vector<Slot<T>>& owner) const {
  transfer<T>(send_, receive_, window, owner, false, true, owner[0].data == window[0].data);
}

template <class T>
void BlockExchange::bring(const std::vector<Array3<T>*>& field) const {
  std::vector<const Array3<T>*> source(field.begin(), field.end());
  transfer<T>(receive_, send_, source, field, true, false, true);
}

#define TWOGRID_INSTANTIATE(T)                                                                                       \
  template void BlockExchange::bring<T>(const std::vector<const Array3<T>*>&, const std::vector<Array3<T>*>&) const; \
  template void BlockExchange::add<T>(const std::vector<const Array3<T>*>&, const std::vector<Array3<T>*>&) const;   \
  template void BlockExchange::bring<T>(const std::vector<Array3<T>*>&) const;
TWOGRID_INSTANTIATE(double)
TWOGRID_INSTANTIATE(long long)
#undef TWOGRID_INSTANTIATE
// NOLINTBEGIN(bugprone-macro-parentheses): a type
#define TWOGRID_INSTANTIATE(T) \
  template void BlockExchange::bring<T>(const std::vector<Slot<T>>&, const std::vector<Slot<T>>&) const;
TWOGRID_INSTANTIATE(double)
TWOGRID_INSTANTIATE(long long)
TWOGRID_INSTANTIATE(FourNumbers)
TWOGRID_INSTANTIATE(FourWholeNumbers)
#undef TWOGRID_INSTANTIATE
// NOLINTEND(bugprone-macro-parentheses)
template void BlockExchange::add<FourWholeNumbers>(const std::vector<Slot<FourWholeNumbers>>&,
                                                   const std::vector<Slot<FourWholeNumbers>>&) const;

FaceExchange::FaceExchange(MPI_Comm comm, const std::array<std::vector<Box>, 3>& owned,
                           const std::array<std::vector<Box>, 3>& wanted, const Int3& period,
                           const std::array<bool, 3>& periodic)
    : comm_(comm) {
  for (int d = 0; d < 3; ++d) part_[d] = BlockExchange(comm, owned[d], wanted[d], period, periodic);
  send_ = join({&part_[0].send_, &part_[1].send_, &part_[2].send_});
  receive_ = join({&part_[0].receive_, &part_[1].receive_, &part_[2].receive_});
  request_.resize(send_.size() + receive_.size());
}

std::vector<FaceExchange::Joint> FaceExchange::join(
    const std::array<const std::vector<BlockExchange::Peer>*, 3>& lists) {
  std::vector<Joint> joint;
  for (int d = 0; d < 3; ++d)
    for (std::size_t p = 0; p < lists[d]->size(); ++p) {
      const BlockExchange::Peer& peer = (*lists[d])[p];
      auto at = std::lower_bound(joint.begin(), joint.end(), peer.rank,
                                 [](const Joint& j, int rank) { return j.rank < rank; });
      if (at == joint.end() || at->rank != peer.rank) at = joint.insert(at, {peer.rank, {-1, -1, -1}, 0});
      at->peer[d] = int(p);
      at->count += peer.count;
    }
  return joint;
}

void FaceExchange::bring(const std::array<Array3<double>*, 3>& field) const {
  constexpr int tag = 4713;
  using Peer = BlockExchange::Peer;
  using Piece = BlockExchange::Piece;
  auto window_box = [](const Piece& q) { return q.owner.shifted(q.shift); };
  double* const in = make_room<double>(receive_, 1, in_);
  double* at = in;
  for (std::size_t p = 0; p < receive_.size(); at += receive_[p++].count)
    MPI_Irecv(at, int(receive_[p].count), MPI_DOUBLE, receive_[p].rank, tag, comm_, &request_[p]);
  double* out = make_room<double>(send_, 1, out_);
  for (std::size_t p = 0; p < send_.size(); ++p) {
    double* const first = out;
    for (int d = 0; d < 3; ++d) {
      if (send_[p].peer[d] < 0) continue;
      const Peer& peer = part_[d].send_[send_[p].peer[d]];
      for (const Piece& q : peer.pieces) pack<double>(field[d], q.owner, out);
    }
    MPI_Isend(first, int(send_[p].count), MPI_DOUBLE, send_[p].rank, tag, comm_, &request_[receive_.size() + p]);
  }
  for (int d = 0; d < 3; ++d)
    for (const Piece& q : part_[d].self_)
      if (!(q.shift == Int3{0, 0, 0})) carry_over(field[d], q.owner, field[d], window_box(q), false);
  const double* arrived = in;
  for (std::size_t p = 0; p < receive_.size(); ++p) {
    MPI_Wait(&request_[p], MPI_STATUS_IGNORE);
    for (int d = 0; d < 3; ++d) {
      if (receive_[p].peer[d] < 0) continue;
      const Peer& peer = part_[d].receive_[receive_[p].peer[d]];
      for (const Piece& q : peer.pieces) unpack<double>(field[d], window_box(q), arrived, false);
    }
  }
  MPI_Waitall(int(send_.size()), request_.data() + receive_.size(), MPI_STATUSES_IGNORE);
}

}  // namespace twogrid
