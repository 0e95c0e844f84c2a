#include "cfd/measures/open_shares.h"

#include <algorithm>

#include "cfd/measures/grid_measures.h"

namespace twogrid {

OpenShares::OpenShares(const GridMeasures& measures, const Box& local, const FaceField<FineGrid>& alpha,
                       CellField<FineGrid> theta, FaceField<FineGrid> theta_f, FaceField<FineGrid> friction,
                       double volume)
    : theta_(std::move(theta)), theta_f_(std::move(theta_f)), friction_(std::move(friction)), volume_(volume) {
  for (int d = 0; d < 3; ++d) {
    ratio_[d].reset(local, 1.0);
    for (std::size_t m = 0; m < theta_f_[d].size(); ++m) {
      double& open = theta_f_[d].data()[m];
      const double a = alpha[d].data()[m];
      if (a > 0 && open > 0) {
        ratio_[d].data()[m] = a / open;
        continue;
      }
      closed_[d].push_back(std::ptrdiff_t(m));
      open_beside_[d].push_back(open > 0 ? 1 / open : 0.0);
      open = ratio_[d].data()[m] = 0;
    }
  }
  set_edges(measures, local, alpha);
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
      const auto mean = [](double low, double high, double share) { return low + share * (high - low); };
      const double *fa = alpha[a].data(), *fb = alpha[b].data(), *c = theta_.data();
      const bool wall = !(fa[m - sb] > 0 && fa[m] > 0 && fb[m - sa] > 0 && fb[m] > 0);
      const double cells = mean(mean(c[m - sa - sb], c[m - sb], ha), mean(c[m - sa], c[m], ha), hb);
      edge_[t].data()[m] = wall ? 0.0 : std::min(mean(fb[m - sa], fb[m], ha), mean(fa[m - sb], fa[m], hb)) / cells;
    });
  }
}

void OpenShares::flux_share(FaceField<FineGrid>& i_f, FaceField<FineGrid>& phi_f) const {
  for (int d = 0; d < 3; ++d) {
    double *i = i_f[d].data(), *phi = phi_f[d].data();
    const double* ratio = ratio_[d].data();
    for (std::size_t m = 0; m < ratio_[d].size(); ++m) phi[m] = ratio[m] * i[m];
    for (std::size_t q = 0; q < closed_[d].size(); ++q) {
      const std::ptrdiff_t m = closed_[d][q];
      i[m] = phi[m] = open_beside_[d][q] > 0 ? i[m] * open_beside_[d][q] : 1.0;
    }
  }
}

}  // namespace twogrid
