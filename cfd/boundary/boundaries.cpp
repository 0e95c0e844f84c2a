#include "cfd/boundary/boundaries.h"

#include <algorithm>
#include <cmath>

#include "cfd/boundary/patches.h"
#include "cfd/parallel/ranks.h"

namespace twogrid {

const std::array<const char*, 6> kSideNames{"xlo", "xhi", "ylo", "yhi", "zlo", "zhi"};

namespace {

/// Index inside [0, n): wrapped where periodic, clamped elsewhere.
int inside(int i, const Axis& axis) {
  const int n = axis.n();
  return axis.periodic() ? ((i % n) + n) % n : std::min(std::max(i, 0), n - 1);
}

/// Factor on the velocity whose mean over the patch is 1 (parabolic), or the table's.
double profile_factor(const BoundaryCondition& c, const Vec3& x, int e, int f, const std::array<double, 4>& extent) {
  const InletProfile& p = c.profile;
  if (p.shape == InletProfile::Shape::kParabolic) {
    if (c.shape.kind == PatchShape::Kind::kCircle) {
      const double a = x[e] - c.shape.value[0], b = x[f] - c.shape.value[1], R = c.shape.value[2];
      return 2 * (1 - (a * a + b * b) / (R * R));
    }
    double factor = 1;
    for (int t = 0; t < 2; ++t) {
      const int d = t == 0 ? e : f;
      if (!p.across[d]) continue;
      const double s = (x[d] - extent[2 * t]) / (extent[2 * t + 1] - extent[2 * t]);
      factor *= 6 * s * (1 - s);
    }
    return factor;
  }
  if (p.shape == InletProfile::Shape::kTable) {
    const auto& t = p.table;
    const double s = x[p.coordinate];
    if (s <= t.front()[0]) return t.front()[1];
    for (std::size_t i = 1; i < t.size(); ++i)
      if (s <= t[i][0]) return t[i - 1][1] + (t[i][1] - t[i - 1][1]) * (s - t[i - 1][0]) / (t[i][0] - t[i - 1][0]);
    return t.back()[1];
  }
  return 1;
}

}  // namespace

Boundaries::Boundaries(MPI_Comm comm, const FineGrid& grid, const Layout& layout, const FluidSettings& settings)
    : grid_(grid), settings_(settings) {
  const int rank = rank_of(comm);
  const Box own = layout.cells(rank);
  for (int d = 0; d < 3; ++d) {
    const Axis& axis = grid.axis[d];
    if (axis.n() == 1 && !axis.periodic()) {
      solved_[d] = false;
      for (int side : {2 * d, 2 * d + 1})
        for (const auto& c : settings.side[side])
          solved_[d] = solved_[d] || c.kind == BoundaryKind::kPressure || c.kind == BoundaryKind::kInlet;
    }
    halo_[d] = d > 0 && !solved_[d] ? 0 : Fluid::kHalo;
  }
  if (!own.empty()) local_ = own.grown(halo_);
  for (int d = 0; d < 3; ++d) state_[d].reset(local_, FaceState::kSolved);

  for (int side = 0; side < 6; ++side) {
    const auto& conditions = settings.side[side];
    for (const auto& c : conditions) velocity_[side].push_back(c.velocity);
    SideData& s = side_[side];
    s.d = direction(side);
    const Axis& axis = grid.axis[s.d];
    if (axis.periodic()) continue;
    s.e = s.d == 0 ? 1 : 0;
    s.f = s.d == 2 ? 1 : 2;
    s.face = is_high(side) ? axis.n() : 0;
    s.inner = is_high(side) ? axis.n() - 1 : 0;
    s.step = is_high(side) ? -1 : 1;
    const bool touches = !own.empty() && (is_high(side) ? own.hi[s.d] == axis.n() : own.lo[s.d] == 0);
    // A halo reaches the ghosts beyond a side over a neighbour that is one cell thick: they are needed there too.
    s.here = touches || (!own.empty() && (is_high(side) ? local_.hi[s.d] > axis.n() : local_.lo[s.d] < 0));
    if (touches) {
      s.own = own;
      s.own.lo[s.d] = s.face;
      s.own.hi[s.d] = s.face + 1;
    }
    if (s.here) {
      s.lo_e = local_.lo[s.e], s.n_e = local_.size(s.e);
      s.lo_f = local_.lo[s.f], s.n_f = local_.size(s.f);
      const std::size_t count = std::size_t(s.n_e) * s.n_f;
      s.condition.assign(count, 0);
      s.profile.assign(count, 1.0);
      s.normal.assign(count, 0.0);
      for (auto* v : {&s.slope, &s.offset}) (*v)[0].assign(count, 0.0), (*v)[1].assign(count, 0.0);
      for (int b = s.lo_f; b < s.lo_f + s.n_f; ++b)
        for (int a = s.lo_e; a < s.lo_e + s.n_e; ++a) {
          Vec3 x;
          const int ia = inside(a, grid.axis[s.e]), ib = inside(b, grid.axis[s.f]);
          x[s.d] = axis.node(s.face);
          x[s.e] = grid.axis[s.e].centre(ia);
          x[s.f] = grid.axis[s.f].centre(ib);
          const int m = s.at(a, b);
          for (int c = 0; c < int(conditions.size()); ++c)
            if (covers(conditions[c].shape, side, x)) s.condition[m] = c;
          const BoundaryCondition& c = conditions[s.condition[m]];
          std::array<double, 4> extent = c.shape.value;
          if (c.shape.kind != PatchShape::Kind::kRectangle)
            extent = {grid.axis[s.e].lo(), grid.axis[s.e].hi(), grid.axis[s.f].lo(), grid.axis[s.f].hi()};
          s.profile[m] = profile_factor(c, x, s.e, s.f, extent);
        }
    }
    normalise_parabolas(comm, s, side);
    for (const auto& c : conditions) open_ = open_ || c.kind == BoundaryKind::kPressure;
  }
  for (int side = 0; side < 6; ++side) {
    SideData& s = side_[side];
    if (!s.here) continue;
    s.outlet.resize(s.condition.size());
    for (int b = s.lo_f; b < s.lo_f + s.n_f; ++b)
      for (int a = s.lo_e; a < s.lo_e + s.n_e; ++a) {
        Int3 c;
        c[s.d] = s.face, c[s.e] = a, c[s.f] = b;
        const bool outlet = settings.side[side][s.condition[s.at(a, b)]].kind == BoundaryKind::kPressure;
        s.outlet[s.at(a, b)] = outlet;
        if (outlet && s.outlet_pressure.empty()) s.outlet_pressure.assign(s.outlet.size(), 0.0);
        state_[s.d](c[0], c[1], c[2]) = outlet ? FaceState::kSolved : FaceState::kFixed;
      }
  }
  update();
}

void Boundaries::normalise_parabolas(MPI_Comm comm, SideData& s, int side) {
  const auto& conditions = settings_.side[side];
  std::vector<double> sum(2 * conditions.size(), 0.0);  // factor times area, area, of every condition
  for_each_face(side, [&](int, int i, int j, int k) {
    const Int3 q{i, j, k};
    const int m = s.at(q[s.e], q[s.f]);
    const double A = open_area(s.d, i, j, k);
    sum[2 * s.condition[m]] += s.profile[m] * A;
    sum[2 * s.condition[m] + 1] += A;
  });
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), int(sum.size()), MPI_DOUBLE, MPI_SUM, comm);
  for (std::size_t m = 0; m < s.profile.size(); ++m) {
    const int c = s.condition[m];
    if (conditions[c].profile.shape == InletProfile::Shape::kParabolic && sum[2 * c] != 0)
      s.profile[m] *= sum[2 * c + 1] / sum[2 * c];
  }
}

double Boundaries::open_area(int d, int i, int j, int k) const {
  const double A = grid_.area(d, i, j, k);
  return shares_ ? A * shares_->alpha(d, state_[d].index(i, j, k)) : A;
}

void Boundaries::close_faces(MPI_Comm comm, const OpenShares& open) {
  shares_ = &open;
  int outlets = 0;
  for (int d = 0; d < 3; ++d)
    for (std::ptrdiff_t m : open.closed(d)) state_[d].data()[m] = FaceState::kFixed;
  for (int side = 0; side < 6; ++side) {
    SideData& s = side_[side];
    if (s.here)
      s.open = OpenRows(s.own, 1, [&](int i, int j, int k) {
        const std::ptrdiff_t m = open.theta().index(i, j, k);
        return open.alpha(s.d, m) > 0 || open.alpha(s.d, m + s.step * open.theta().stride(s.d)) > 0;
      });
    normalise_parabolas(comm, s, side);
    for_each_face(side,
                  [&](int, int i, int j, int k) { outlets += state_[side_[side].d](i, j, k) == FaceState::kSolved; });
  }
  MPI_Allreduce(MPI_IN_PLACE, &outlets, 1, MPI_INT, MPI_SUM, comm);
  open_ = outlets > 0;
  known_ = false;
  update();
}

void Boundaries::update() {
  for (int side = 0; side < 6; ++side) {
    const auto& conditions = settings_.side[side];
    bool changed = !known_;
    for (std::size_t c = 0; c < conditions.size(); ++c) {
      const Vec3 now = conditions[c].velocity_now ? conditions[c].velocity_now() : conditions[c].velocity;
      changed = changed || now != velocity_[side][c];
      velocity_[side][c] = now;
    }
    SideData& s = side_[side];
    if (!s.here || !changed) continue;
    for (std::size_t m = 0; m < s.normal.size(); ++m) {
      const BoundaryCondition& c = conditions[s.condition[m]];
      s.normal[m] = c.kind == BoundaryKind::kInlet ? velocity_[side][s.condition[m]][s.d] * s.profile[m] : 0.0;
    }
    if (shares_)
      for_each_inner(s, shares_->theta(), [&](int m, std::ptrdiff_t in) {
        const std::ptrdiff_t face = in + (s.step < 0 ? shares_->theta().stride(s.d) : 0);
        if (!(shares_->alpha(s.d, face) > 0)) s.normal[m] = 0;
      });
    set_tangential(s, side);
  }
  known_ = true;
}

template <class F>
void Boundaries::for_each_inner(const SideData& s, const Array3<double>& like, F&& f) {
  Int3 in;
  in[s.d] = s.inner, in[s.e] = s.lo_e, in[s.f] = s.lo_f;
  const std::ptrdiff_t first = like.index(in[0], in[1], in[2]), se = like.stride(s.e), sf = like.stride(s.f);
  for (int b = 0; b < s.n_f; ++b) {
    const int at = s.n_e * b;
    const std::ptrdiff_t row = first + b * sf;
    if (se == 1)
      for (int a = 0; a < s.n_e; ++a) f(at + a, row + a);
    else
      for (int a = 0; a < s.n_e; ++a) f(at + a, row + a * se);
  }
}

void Boundaries::set_tangential(SideData& s, int side) {
  // A tangential velocity stands on the edge between two boundary faces. Where their conditions differ, one that
  // prescribes a value wins over one that doesn't; two that prescribe are averaged.
  const auto& conditions = settings_.side[side];
  for (int t = 0; t < 2; ++t) {
    const int dir = t == 0 ? s.e : s.f;
    for (int b = s.lo_f; b < s.lo_f + s.n_f; ++b)
      for (int a = s.lo_e; a < s.lo_e + s.n_e; ++a) {
        const int m = s.at(a, b);
        const int below = t == 0 ? (a > s.lo_e ? s.at(a - 1, b) : m) : (b > s.lo_f ? s.at(a, b - 1) : m);
        double sum = 0;
        int prescribed = 0;
        for (int q : {m, below}) {
          const BoundaryCondition& c = conditions[s.condition[q]];
          if (c.kind == BoundaryKind::kNoSlip || c.kind == BoundaryKind::kInlet) {
            const double factor = c.kind == BoundaryKind::kInlet ? s.profile[q] : 1.0;
            sum += velocity_[side][s.condition[q]][dir] * factor;
            ++prescribed;
          }
        }
        s.slope[t][m] = prescribed ? -1.0 : 1.0;
        s.offset[t][m] = prescribed ? 2.0 * sum / prescribed : 0.0;
      }
  }
}

void Boundaries::apply_normal(FaceField<FineGrid>& u, bool homogeneous) const {
  const double on = homogeneous ? 0.0 : 1.0;
  for (const SideData& s : side_) {
    if (!s.here) continue;
    double* v = u[s.d].data();
    const std::ptrdiff_t to_face = s.step < 0 ? u[s.d].stride(s.d) : 0;
    for_each_inner(s, u[s.d], [&](int m, std::ptrdiff_t in) {
      if (!s.outlet[m]) v[in + to_face] = on * s.normal[m];
    });
  }
  // With links nothing is ever written to closed faces but zero (Predictor).
  if (!shares_ || shares_->has_links()) return;
  for (int d = 0; d < 3; ++d) shares_->close(d, u[d].data());
}

void Boundaries::apply(FaceField<FineGrid>& u, bool homogeneous) const {
  apply_normal(u, homogeneous);
  const double on = homogeneous ? 0.0 : 1.0;
  for (const SideData& s : side_) {
    if (!s.here) continue;
    auto held = [&](int i) { return i >= local_.lo[s.d] && i < local_.hi[s.d]; };
    const std::ptrdiff_t inwards = s.step * u[s.d].stride(s.d), to_face = s.step < 0 ? u[s.d].stride(s.d) : 0;
    // Sides are taken one after the other, each with all components: at edges the later ones have the last word.
    for (int g = 1; g <= Fluid::kHalo; ++g) {
      // Normal component: constant beyond the boundary face.
      if (!held(s.face - s.step * g)) continue;
      double* v = u[s.d].data() + to_face;
      for_each_inner(s, u[s.d], [&](int, std::ptrdiff_t in) { v[in - g * inwards] = v[in]; });
    }
    for (int t = 0; t < 2; ++t) {
      auto& component = u[t == 0 ? s.e : s.f];
      double* v = component.data();
      const double *slope = s.slope[t].data(), *offset = s.offset[t].data();
      for (int g = 0; g < Fluid::kHalo; ++g) {
        if (!held(s.inner - s.step * (1 + g))) continue;
        const std::ptrdiff_t from = held(s.inner + s.step * g) ? g * inwards : 0, to = -(1 + g) * inwards;
        for_each_inner(s, component,
                       [&](int m, std::ptrdiff_t in) { v[in + to] = slope[m] * v[in + from] + on * offset[m]; });
      }
    }
  }
}

void Boundaries::set_outlet_pressure(const FaceField<FineGrid>& u, double density) {
  for (int side = 0; side < 6; ++side) {
    SideData& s = side_[side];
    if (s.outlet_pressure.empty()) continue;
    const std::ptrdiff_t to_face = s.step < 0 ? u[s.d].stride(s.d) : 0;
    const double* normal = u[s.d].data();
    for_each_inner(s, u[s.d], [&](int m, std::ptrdiff_t in) {
      if (!s.outlet[m]) return;
      const double inward = s.step * normal[in + to_face];
      s.outlet_pressure[m] =
          settings_.side[side][s.condition[m]].pressure - (inward > 0 ? 0.5 * density * inward * inward : 0.0);
    });
  }
}

void Boundaries::apply_pressure(CellField<FineGrid>& p) const {
  for (const SideData& s : side_) {
    if (!s.here) continue;
    const std::ptrdiff_t outwards = -s.step * p.stride(s.d);
    double* v = p.data();
    for_each_inner(s, p, [&](int m, std::ptrdiff_t in) {
      v[in + outwards] = s.outlet[m] ? 2 * s.outlet_pressure[m] - v[in] : v[in];
    });
  }
}

void Boundaries::apply_correction(CellField<FineGrid>& phi) const {
  for (const SideData& s : side_) {
    if (!s.here) continue;
    const std::ptrdiff_t outwards = -s.step * phi.stride(s.d);
    double* v = phi.data();
    for_each_inner(s, phi, [&](int m, std::ptrdiff_t in) { v[in + outwards] = s.outlet[m] ? 0.0 : v[in]; });
  }
}

void Boundaries::apply_face_eps(FaceField<FineGrid>& eps_f) const {
  for (int side = 0; side < 6; ++side) {
    const SideData& s = side_[side];
    const auto& conditions = settings_.side[side];
    const auto is_inlet = [](const BoundaryCondition& c) { return c.kind == BoundaryKind::kInlet; };
    if (!s.here || std::none_of(conditions.begin(), conditions.end(), is_inlet)) continue;
    for (int b = s.lo_f; b < s.lo_f + s.n_f; ++b)
      for (int a = s.lo_e; a < s.lo_e + s.n_e; ++a) {
        if (!is_inlet(conditions[s.condition[s.at(a, b)]])) continue;
        Int3 c;
        c[s.d] = s.face, c[s.e] = a, c[s.f] = b;
        const double open = shares_ ? shares_->theta_f()[s.d](c[0], c[1], c[2]) : 1.0;
        if (open > 0) eps_f[s.d](c[0], c[1], c[2]) = open;
      }
  }
}

BoundaryKind Boundaries::kind(int side, int i, int j, int k) const {
  const SideData& s = side_[side];
  const Int3 c{i, j, k};
  return settings_.side[side][s.condition[s.at(c[s.e], c[s.f])]].kind;
}

std::vector<PatchArea> Boundaries::areas(MPI_Comm comm) const {
  std::vector<PatchArea> list;
  std::vector<double> sums;
  for (int side = 0; side < 6; ++side) {
    const SideData& s = side_[side];
    for (int c = 0; c < int(settings_.side[side].size()); ++c) {
      if (settings_.side[side][c].kind != BoundaryKind::kInlet) continue;
      double area = 0, flux = 0;
      for_each_face(side, [&](int, int i, int j, int k) {
        const Int3 q{i, j, k};
        const int m = s.at(q[s.e], q[s.f]);
        if (s.condition[m] != c) return;
        const double A = open_area(s.d, i, j, k);
        area += A;
        flux += s.step * s.normal[m] * A;
      });
      list.push_back({settings_.side[side][c].name, side, 0, 0});
      sums.push_back(area);
      sums.push_back(flux);
    }
  }
  if (!sums.empty()) MPI_Allreduce(MPI_IN_PLACE, sums.data(), int(sums.size()), MPI_DOUBLE, MPI_SUM, comm);
  for (std::size_t i = 0; i < list.size(); ++i) list[i].area = sums[2 * i], list[i].flux = sums[2 * i + 1];
  return list;
}

}  // namespace twogrid
