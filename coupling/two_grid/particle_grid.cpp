#include "coupling/two_grid/particle_grid.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "coupling/two_grid/open_nodes.h"

namespace twogrid {

ParticleGrid::ParticleGrid(const FineGrid& fine, const Int3& r) : ratio(r) {
  for (int d = 0; d < 3; ++d) {
    const std::string where = std::string(" in direction ") + "xyz"[d];
    if (r[d] < 1) throw std::invalid_argument("ratio must be at least 1" + where + ", found " + std::to_string(r[d]));
    const int n = fine.axis[d].n();
    if (n % r[d] != 0)
      throw std::invalid_argument("ratio " + std::to_string(r[d]) + " does not divide the " + std::to_string(n) +
                                  " fine cells" + where + ": change ratio or fine");
    std::vector<double> node;
    for (int i = 0; i <= n; i += r[d]) node.push_back(fine.axis[d].node(i));
    axis[d] = Axis(std::move(node), fine.axis[d].periodic());
  }
}

void ParticleGrid::take_open_part(MPI_Comm comm, const Fluid& fluid, const Int3& search) {
  if (!fluid.open_shares()) return;
  open_ = std::make_shared<OpenNodes>(comm, fluid, *this, search);
  volume_ = &open_->volumes();
}

double ParticleGrid::shown_volume(int i, int j, int k) const {
  return open_ ? open_->family_volume(i, j, k) : Grid::volume(i, j, k);
}

double ParticleGrid::domain_volume(MPI_Comm comm) const {
  if (!open_) return axis[0].length() * axis[1].length() * axis[2].length();
  double sum = 0;
  for_each(volume_->box(), [&](int i, int j, int k) { sum += (*volume_)(i, j, k); });
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm);
  return sum;
}

double ParticleGrid::largest_volume() const {
  double v = 1;
  for (const Axis& a : axis) {
    double width = 0;
    for (int i = 0; i < a.n(); ++i) width = std::max(width, a.width(i));
    v *= width;
  }
  return v;
}

double ParticleGrid::smallest_width() const {
  double width = 1e300;
  for (const Axis& a : axis)
    if (a.n() > 1) width = std::min(width, a.length() / a.n());
  return width;
}

Layout node_layout(const Layout& fine, const ParticleGrid& nodes) {
  for (int d = 0; d < 3; ++d)
    for (int c : fine.cuts()[d])
      if (c % nodes.ratio[d] != 0)
        throw std::invalid_argument("the fluid's layout is cut at fine cell " + std::to_string(c) + " in direction " +
                                    "xyz"[d] + ", wanted: a multiple of ratio " + std::to_string(nodes.ratio[d]));
  return fine.coarsened(nodes, nodes.ratio);
}

}  // namespace twogrid
