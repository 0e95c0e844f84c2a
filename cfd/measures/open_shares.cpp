#include "cfd/measures/open_shares.h"

#include <algorithm>
#include <cmath>

#include "cfd/measures/grid_measures.h"
#include "cfd/parallel/vectorised.h"

namespace twogrid {

namespace {

double mean(double low, double high, double share_of_high) {
  return low + share_of_high * (high - low);
}

/// product = share times values. A share of -1 is that of faces among closed cells, whose value is 0: both become 1.
TWOGRID_VECTORISED void take_shares(std::size_t n, const double* share, double* __restrict values,
                                    double* __restrict product) {
#pragma GCC ivdep
  for (std::size_t m = 0; m < n; ++m) {
    const double s = share[m], least = -s, v = values[m] > least ? values[m] : least;
    values[m] = v, product[m] = std::abs(s) * v;
  }
}

}  // namespace

OpenShares::OpenShares(const GridMeasures& measures, const Box& local, const Box& own, const std::array<Box, 3>& faces,
                       const std::array<bool, 3>& solved, Held held)
    : theta_(std::move(held.theta)),
      theta_f_(std::move(held.theta_f)),
      friction_(std::move(held.friction)),
      links_(std::move(held.links)),
      without_convection_(std::move(held.own)),
      beside_(std::move(held.beside)),
      slivers_(std::move(held.slivers)),
      pieces_(std::move(held.pieces)),
      surface_(std::move(held.surface)),
      outlines_(std::move(held.outlines)),
      volume_(held.volume) {
  for (int d = 0; d < 3; ++d) {
    centre_[d] = exceptions(held.centre[d]), viscous_[d] = exceptions(held.viscous[d]);
    wall_velocity_[d] = exceptions(held.wall_velocity[d], 0), drift_[d] = exceptions(held.drift[d], 0);
    ratio_[d].reset(local, 1.0);
    for (std::size_t m = 0; m < theta_f_[d].size(); ++m) {
      double& open = theta_f_[d].data()[m];
      const double a = held.alpha[d].data()[m];
      if (a > 0 && open > 0) {
        ratio_[d].data()[m] = a / open;
        continue;
      }
      closed_[d].push_back(std::ptrdiff_t(m));
      const auto append = [m = std::ptrdiff_t(m)](std::vector<Run>& runs) {
        if (!runs.empty() && runs.back().first + runs.back().length == m)
          ++runs.back().length;
        else
          runs.push_back({m, 1});
      };
      append(closed_runs_[d]);
      ratio_[d].data()[m] = open > 0 ? 0 : -1;
      if (open > 0) open_beside_[d].push_back({std::ptrdiff_t(m), 1 / open});
      open = 0;
    }
  }
  if (held.blown_body[0].size() > 0) list_blown(held);
  cells_ = OpenRows(own, OpenRows::kFloats, [&](int i, int j, int k) { return theta_(i, j, k) > 0; });
  for (int d = 0; d < 3; ++d) {
    const FaceComponent<FineGrid>& open = theta_f_[d];  // 0: closed
    faces_[d] = OpenRows(faces[d], OpenRows::kDoubles, [&](int i, int j, int k) { return open(i, j, k) > 0; });
    surroundings_[d] = OpenRows(faces[d], OpenRows::kDoubles, [&](int i, int j, int k) {
      const double* at = &open.data()[open.index(i, j, k)];
      for (int e = 0; e < 3; ++e)
        if (at[-open.stride(e)] > 0 || at[open.stride(e)] > 0) return true;
      return *at > 0;
    });
  }
  if (has_links())
    set_uncut(measures, local, solved, held.alpha);
  else
    set_edges(measures, local, held.alpha);
}

OpenShares::Exceptions OpenShares::exceptions(const Array3<double>& field, double usual) {
  Exceptions list;
  for (std::size_t m = 0; m < field.size(); ++m)
    if (field.data()[m] != usual) list.push_back({std::ptrdiff_t(m), field.data()[m]});
  return list;
}

double OpenShares::looked_up(const Exceptions& list, std::ptrdiff_t m, double usual) {
  const auto found = std::lower_bound(list.begin(), list.end(), m,
                                      [](const auto& entry, std::ptrdiff_t at) { return entry.first < at; });
  return found != list.end() && found->first == m ? found->second : usual;
}

/// Numbers that walls which blow have a part in; no list that holds some may change its length after this.
void OpenShares::list_blown(Held& held) {
  int bodies = 0;
  const auto list = [&](double* number, int body, double share) {
    bodies = std::max(bodies, body + 1);
    if (share != 0) blown_.push_back({number, body, *number, share});
  };
  for (int d = 0; d < 3; ++d) {
    const Array3<double>& of = held.blown_body[d];
    const auto add = [&](Exceptions& numbers, const Array3<double>& at_rest, const Array3<double>& share) {
      numbers.clear();
      for (std::size_t m = 0; m < of.size(); ++m) {
        const double rest = at_rest.size() > 0 ? at_rest.data()[m] : 0.0;
        if (rest != 0 || (of.data()[m] >= 0 && share.data()[m] != 0)) numbers.push_back({std::ptrdiff_t(m), rest});
      }
      for (auto& n : numbers)
        if (of.data()[n.first] >= 0) list(&n.second, int(of.data()[n.first]), share.data()[n.first]);
    };
    add(wall_velocity_[d], held.wall_velocity[d], held.blown_velocity[d]);
    add(drift_[d], held.drift[d], held.blown_drift[d]);
  }
  for (const OpenSpace::Blown& b : held.blown_pieces) list(&pieces_[b.place].velocity, b.body, b.velocity);
  for (const OpenSpace::Blown& b : held.blown_slivers) {
    list(&slivers_[b.place].velocity, b.body, b.velocity);
    list(&slivers_[b.place].drift, b.body, b.drift);
  }
  set_blowing(std::vector<double>(bodies, 1.0));
}

void OpenShares::set_blowing(const std::vector<double>& velocity) {
  for (const BlownNumber& b : blown_) *b.number = b.at_rest;
  for (const BlownNumber& b : blown_) *b.number += velocity[b.body] * b.share;
}

/// Mean of theta over the four cells around the edge along t at the low corner of cell x.
double OpenShares::theta_around(const GridMeasures& measures, int t, const Int3& x) const {
  const int a = (t + 1) % 3, b = (t + 2) % 3;
  const std::ptrdiff_t sa = theta_.stride(a), sb = theta_.stride(b);
  const double* c = theta_.data() + theta_.index(x[0], x[1], x[2]);
  const double ha = measures.axis(a).above_share_[x[a] - measures.axis(a).lo],
               hb = measures.axis(b).above_share_[x[b] - measures.axis(b).lo];
  return mean(mean(c[-sa - sb], c[-sb], ha), mean(c[-sa], c[0], ha), hb);
}

/// A link between two faces through an edge is open where the side it passes is; one to a closed face is a wall's.
void OpenShares::set_edges(const GridMeasures& measures, const Box& local, const FaceField<FineGrid>& alpha) {
  for (int t = 0; t < 3; ++t) {
    const int a = (t + 1) % 3, b = (t + 2) % 3;
    edge_[t].reset(local, 1.0);
    Box inner = local;
    for (int d : {a, b})
      if (local.size(d) > 1) ++inner.lo[d];
    const std::ptrdiff_t sa = theta_.stride(a), sb = theta_.stride(b);
    for_each(inner, [&](int i, int j, int k) {
      const Int3 x{i, j, k};
      const std::ptrdiff_t m = theta_.index(i, j, k);
      const double ha = measures.axis(a).above_share_[x[a] - measures.axis(a).lo],
                   hb = measures.axis(b).above_share_[x[b] - measures.axis(b).lo];
      const double *fa = alpha[a].data(), *fb = alpha[b].data();
      const bool wall = !(fa[m - sb] > 0 && fa[m] > 0 && fb[m - sa] > 0 && fb[m] > 0);
      edge_[t].data()[m] =
          wall ? 0.0
               : std::min(mean(fb[m - sa], fb[m], ha), mean(fa[m - sb], fa[m], hb)) / theta_around(measures, t, x);
    });
  }
}

/// Where a link beside an edge or in a cell is cut, or ends at a face that is, the whole stress there is left out.
void OpenShares::set_uncut(const GridMeasures& measures, const Box& local, const std::array<bool, 3>& solved,
                           const FaceField<FineGrid>& alpha) {
  const auto whole = [&](int c, std::ptrdiff_t m) { return alpha[c].data()[m] == 1 && !sliver(c, m); };
  const double* theta = theta_.data();
  for (int t = 0; t < 3; ++t) {
    const int a = (t + 1) % 3, b = (t + 2) % 3;
    edge_[t].reset(local, 1.0);
    if (!solved[a] || !solved[b]) continue;
    Box inner = local;
    for (int d : {a, b}) ++inner.lo[d];
    const std::ptrdiff_t sa = theta_.stride(a), sb = theta_.stride(b);
    for_each(inner, [&](int i, int j, int k) {
      const std::ptrdiff_t m = theta_.index(i, j, k);
      const bool uncut = whole(a, m - sb) && whole(a, m) && whole(b, m - sa) && whole(b, m) && linked(a, b, m - sb) &&
                         linked(b, a, m - sa);
      edge_[t].data()[m] = uncut ? 1 / theta_around(measures, t, {i, j, k}) : 0.0;
    });
  }
  cell_.reset(local, 1.0);
  Box inner = local;
  for (int c = 0; c < 3; ++c)
    if (solved[c]) --inner.hi[c];
  for_each(inner, [&](int i, int j, int k) {
    const std::ptrdiff_t m = theta_.index(i, j, k);
    bool uncut = true;
    for (int c = 0; c < 3; ++c)
      uncut = uncut && (!solved[c] || (whole(c, m) && whole(c, m + theta_.stride(c)) && linked(c, c, m)));
    cell_.data()[m] = uncut ? 1 / theta[m] : 0.0;
  });
}

void OpenShares::flux_share(FaceField<FineGrid>& i_f, FaceField<FineGrid>& phi_f) const {
  for (int d = 0; d < 3; ++d) {
    double *i = i_f[d].data(), *phi = phi_f[d].data();
    take_shares(ratio_[d].size(), ratio_[d].data(), i, phi);
    for (const auto& beside : open_beside_[d]) i[beside.first] = phi[beside.first] = i[beside.first] * beside.second;
  }
}

void OpenShares::close(int d, double* face) const {
  for (const Run& run : closed_runs_[d]) std::fill_n(face + run.first, run.length, 0.0);
}

}  // namespace twogrid
