#include "coupling/selection/selection.h"

#include <algorithm>
#include <cmath>

#include "cfd/parallel/vectorised.h"

namespace twogrid {

namespace {

bool within(const double x[3], const Vec3& lo, const Vec3& hi) {
  return x[0] >= lo[0] && x[1] >= lo[1] && x[2] >= lo[2] && x[0] <= hi[0] && x[1] <= hi[1] && x[2] <= hi[2];
}

/// Particles that lie where they surely may go to `inside`, the others that take part to `others`, both in order.
TWOGRID_VECTORISED void sort_out(const Particles& p, const Vec3& surely_lo, const Vec3& surely_hi,
                                 std::vector<int>& inside, std::vector<int>& others) {
  const Four lo{surely_lo[0], surely_lo[1], surely_lo[2], -HUGE_VAL};
  const Four hi{surely_hi[0], surely_hi[1], surely_hi[2], HUGE_VAL};
  inside.resize(p.n);
  others.clear();
  int* const to = inside.data();
  int n = 0;
  for (int i = 0; i < p.n; ++i) {
    if (!p.takes_part(i)) continue;
    Four x;
    three_at(p.x[i], i + 1 == p.n, x);
    const FourIntegers within = (x >= lo) & (x <= hi);
    to[n] = i;
    if ((within[0] & within[1] & within[2]) != 0)
      ++n;
    else
      others.push_back(i);
  }
  inside.resize(n);
}

}  // namespace

Selection::Selection(MPI_Comm comm, const ParticleGrid& grid, const Layout& nodes, const Window& window,
                     const ParticleRegion& region)
    : comm_(comm), grid_(grid), nodes_(nodes), window_(window), region_(region) {
  find_bounds();
}

void Selection::move_region(const ParticleRegion& region) {
  region_ = region;
  find_bounds();
}

/// A particle a little beyond the box is still there, until it is exchanged. Where the box goes on beyond the fluid's
/// domain, such a particle has no place in it.
void Selection::find_bounds() {
  if (grid_.open_nodes()) open_ = Window(comm_, grid_, nodes_, region_, Spread::kCell, 0.0);
  double reaches[6], box[6];  // upwards
  for (int d = 0; d < 3; ++d) reaches[2 * d] = -region_.lo[d], reaches[2 * d + 1] = region_.hi[d];
  MPI_Allreduce(reaches, box, 6, MPI_DOUBLE, MPI_MAX, comm_);
  for (int d = 0; d < 3; ++d) {
    const Axis& a = grid_.axis[d];
    const double same = 1e-9 * a.length();
    inside_lo_[d] = a.periodic() ? -HUGE_VAL : a.lo() - (a.lo() + box[2 * d] < same ? region_.reach : 0.0);
    inside_hi_[d] = a.periodic() ? HUGE_VAL : a.hi() + (box[2 * d + 1] - a.hi() < same ? region_.reach : 0.0);
    surely_lo_[d] = std::max(inside_lo_[d], window_.span(d).x_lo);
    surely_hi_[d] = std::min(inside_hi_[d], window_.span(d).x_hi);
  }
}

void Selection::find(const Particles& p) {
  sort_out(p, surely_lo_, surely_hi_, inside_, others_);
  leaving_.clear();
  covered_ = true;
  const std::size_t sure = inside_.size();
  for (int i : others_)
    if (within(p.x[i], inside_lo_, inside_hi_) || !std::isfinite(p.x[i][0] + p.x[i][1] + p.x[i][2])) {
      inside_.push_back(i);  // what is not finite too: take_census() speaks of it
      covered_ &= window_.covers(p.x[i]);
    } else if (p.step[i][kDragCoefficient] > 0) {
      leaving_.push_back(i);
    } else {
      set_outside(p, i);
    }
  if (inside_.size() > sure) std::inplace_merge(inside_.begin(), inside_.begin() + sure, inside_.end());
  if (open_.cut()) look_for_walls(p);
}

/// Takes those out of inside_ that lie deep in a body.
void Selection::look_for_walls(const Particles& p) {
  in_walls_ = behind_walls_ = 0, tag_behind_ = -1;
  std::size_t n = 0;
  for (int i : inside_) {
    inside_[n++] = i;
    const double* const x = p.x[i];
    if (open_.is_open(open_.node(x))) continue;
    if (!std::isfinite(x[0] + x[1] + x[2]) || open_.is_open(open_.open_node(x))) {
      ++in_walls_;
      continue;
    }
    ++behind_walls_;
    tag_behind_ = std::max(tag_behind_, p.tag ? (long long)p.tag[i] : (long long)i);
    --n;
    if (p.step[i][kDragCoefficient] > 0)
      leaving_.push_back(i);
    else
      set_outside(p, i);
  }
  inside_.resize(n);
}

void Selection::find_new(const Particles& p, bool any) {
  new_.clear();
  if (!any) return;
  for (int i : inside_)
    if (p.state[i][kVoidFraction] == 0) new_.push_back(i);
}

void Selection::set_outside(const Particles& p, int i) {
  double* s = p.state[i];
  std::fill(s, s + kParticleColumns, 0.0);
  std::fill(p.step[i], p.step[i] + kStepColumns, 0.0);
  s[kVoidFraction] = s[kKnown] = 1;
  for (int d = 0; d < 3; ++d) s[kPathVelocity + d] = p.v[i][d], s[kPosition + d] = p.x[i][d];
}

long long Selection::find_bad(const Particles& p, double& not_finite, double& uncovered) const {
  long long bad_tag = -1;
  for (const std::vector<int>* list : {&inside_, &leaving_})
    for (int i : *list) {
      double sum = 0;
      for (int d = 0; d < 3; ++d) sum += p.x[i][d] + p.v[i][d] + p.step[i][kImpulse + d];
      const bool finite = std::isfinite(sum);
      if (finite && (list == &leaving_ || window_.covers(p.x[i]))) continue;
      ++(finite ? uncovered : not_finite);
      bad_tag = std::max(bad_tag, p.tag ? (long long)p.tag[i] : (long long)i);
    }
  return bad_tag;
}

}  // namespace twogrid
