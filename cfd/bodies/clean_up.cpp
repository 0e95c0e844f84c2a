#include "cfd/bodies/clean_up.h"

#include <algorithm>
#include <sstream>

#include "cfd/bodies/sentences.h"

namespace twogrid {

/// Open, and not at a side that lets nothing pass.
bool CleanUp::leads_on(int d, const Int3& face) const {
  if (!grid_.solved[d] || !(alpha_[d](face[0], face[1], face[2]) > 0)) return false;
  const int side = grid_.side_of(d, face[d]);
  return side < 0 || grid_.passes(side, face);
}

void CleanUp::close_slivers() {
  const LocalGrid& g = grid_;
  for (int changed = 1; changed > 0;) {
    changed = 0;
    for (int d = 0; d < 3; ++d)
      for_each(g.own_faces[d], [&](int i, int j, int k) {
        double& a = alpha_[d](i, j, k);
        if (a == 0) return;
        Int3 below{i, j, k};
        --below[d];
        const bool open = (!g.inside(d, below[d]) || theta_(below[0], below[1], below[2]) > 0) &&
                          (!g.inside(d, below[d] + 1) || theta_(i, j, k) > 0);
        if (a < kLeastShare || !open) a = 0, changed = 1;
      });
    g.face_halo.bring(alpha_);
    for_each(g.own, [&](int i, int j, int k) {
      double& t = theta_(i, j, k);
      if (t == 0) return;
      bool any = false;
      double largest = 0;
      for (int d = 0; d < 3; ++d)
        for (int up = 0; up < 2; ++up) {
          Int3 face{i, j, k};
          face[d] += up;
          any = any || leads_on(d, face);
          largest = std::max(largest, alpha_[d](face[0], face[1], face[2]));
        }
      if (!any || t < kLeastShare * largest) t = 0, changed = 1;
    });
    g.cell_halo.bring(theta_);
    MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_MAX, g.comm);
  }
}

/// What flows in must be able to flow out of the same part; and parts without an outlet can't be beside others, for their
/// pressures have no common level.
void CleanUp::refuse_dead_ends(const ConnectedParts& parts, const std::vector<int>& mark,
                               const std::vector<double>& volume, const std::vector<bool>& stays) const {
  const LocalGrid& g = grid_;
  std::size_t open = 0;
  for (bool s : stays) open += s;
  for (int p = 0; p < parts.count(); ++p) {
    if (!stays[p] || mark[p * kMarks + kOutlet] || (open == 1 && !mark[p * kMarks + kInlet])) continue;
    std::ostringstream s;
    for_each(g.own, [&](int i, int j, int k) {
      if (g.number(i, j, k) != parts.first(p)) return;
      const Vec3 x{g.centre(0, i), g.centre(1, j), g.centre(2, k)};
      s << "the bodies part " << volume[p] << " m3 of fluid at " << words(x) << " from all outlets"
        << (mark[p * kMarks + kInlet] ? ", and an inlet leads into it" : ", and there is other fluid besides")
        << "; wanted: a way to an outlet, or the fluid's side of the surfaces as it is meant (fluid_at x y z)";
    });
    refuse_together(g.comm, s.str());
  }
}

double CleanUp::close_pockets(const std::vector<Int3>& held) {
  const LocalGrid& g = grid_;
  const ConnectedParts parts(
      g, g.own, g.cells, g.cell_halo, [&](int i, int j, int k) { return theta_(i, j, k) > 0; },
      [&](int d, int i, int j, int k) {
        Int3 face{i, j, k};
        ++face[d];
        return alpha_[d](face[0], face[1], face[2]) > 0;
      });
  const int n = parts.count();
  std::vector<int> mark(std::size_t(n) * kMarks, 0);
  std::vector<double> volume(n, 0.0);
  for_each(g.own, [&](int i, int j, int k) {
    const int p = parts.at(i, j, k);
    if (p < 0) return;
    volume[p] += theta_(i, j, k) * g.volume({i, j, k});
    for (int d = 0; d < 3; ++d)
      for (int up = 0; up < 2; ++up) {
        Int3 face{i, j, k};
        face[d] += up;
        const int side = g.side_of(d, face[d]);
        if (side < 0 || !leads_on(d, face)) continue;
        const BoundaryKind kind = g.settings.side[side][g.condition(side, face)].kind;
        mark[p * kMarks + (kind == BoundaryKind::kInlet ? kInlet : kOutlet)] = 1;
      }
  });
  for (const Int3& v : held)
    for (int q = 0; q < 8; ++q) {
      const Int3 c{v[0] - (q & 1), v[1] - (q >> 1 & 1), v[2] - (q >> 2)};
      const int p = g.cells.contains(c[0], c[1], c[2]) ? parts.at(c[0], c[1], c[2]) : -1;
      if (p >= 0) mark[p * kMarks + kHeld] = 1;
    }
  MPI_Allreduce(MPI_IN_PLACE, mark.data(), int(mark.size()), MPI_INT, MPI_MAX, g.comm);
  MPI_Allreduce(MPI_IN_PLACE, volume.data(), n, MPI_DOUBLE, MPI_SUM, g.comm);
  std::vector<bool> stays(n);
  for (int p = 0; p < n; ++p)
    stays[p] = mark[p * kMarks + kInlet] || mark[p * kMarks + kOutlet] || mark[p * kMarks + kHeld];
  if (n > 0 && std::find(stays.begin(), stays.end(), true) == stays.end())
    stays[std::max_element(volume.begin(), volume.end()) - volume.begin()] = true;
  refuse_dead_ends(parts, mark, volume, stays);
  double closed = 0;
  for (int p = 0; p < n; ++p) closed += stays[p] ? 0 : volume[p];
  if (closed > 0) {
    for_each(g.cells, [&](int i, int j, int k) {
      const int p = parts.at(i, j, k);
      if (p >= 0 && !stays[p]) theta_(i, j, k) = 0;
    });
    close_slivers();
  }
  return closed;
}

}  // namespace twogrid
