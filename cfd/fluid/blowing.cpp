#include "cfd/fluid/blowing.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cfd/fluid/domain.h"

namespace twogrid {

Blowing::Blowing(const FluidDomain& domain, const std::vector<Body>& bodies,
                 const std::vector<OpenSpace::BlownCell>& cells)
    : bodies_(bodies),
      velocity_(bodies.size(), 0.0),
      area_(bodies.size(), 0.0),
      sums_(bodies.size()),
      rate_(domain.local) {
  // Own faces have parts of cells of other ranks.
  CellField<FineGrid> body(domain.local), size(domain.local);
  std::array<CellField<FineGrid>, 3> area, along;
  body.fill(-1);
  for (int d = 0; d < 3; ++d) area[d].reset(domain.local), along[d].reset(domain.local);
  const std::vector<WallCell>& surface = domain.measures.open()->surface();
  auto wall = surface.begin();
  for (const OpenSpace::BlownCell& c : cells) {
    const std::ptrdiff_t m = body.index(c.cell[0], c.cell[1], c.cell[2]);
    cells_.push_back({m, c.cell, c.body, c.size, domain.measures.cell_volume(c.cell[0], c.cell[1], c.cell[2]), {}, {}});
    // Both lists go through the cells in the same order.
    while (wall != surface.end() && wall->cell != c.cell) ++wall;
    if (wall != surface.end()) find_next(domain, *wall, cells_.back());
    area_[c.body] += c.size;
    body.data()[m] = c.body, size.data()[m] = c.size;
    for (int d = 0; d < 3; ++d) area[d].data()[m] = c.area[d], along[d].data()[m] = c.along[d];
  }
  for (CellField<FineGrid>* f : {&body, &size, &area[0], &area[1], &area[2], &along[0], &along[1], &along[2]})
    domain.fill(*f);
  MPI_Allreduce(MPI_IN_PLACE, area_.data(), int(area_.size()), MPI_DOUBLE, MPI_SUM, domain.comm);
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (bodies[b].blow.on && !(area_[b] > 0))
      throw std::invalid_argument("solid " + bodies[b].name + " blow: found no part of its surface in the fluid" +
                                  (bodies[b].blow.where
                                       ? " that lies in the region, wanted a region that holds some of the surface"
                                       : ", wanted a body whose surface the fluid meets"));
  const OpenShares& open = *domain.measures.open();
  const auto of_half = [&](std::ptrdiff_t m, int c) {
    return Push{0.5 * area[c].data()[m], 0.5 * size.data()[m] * along[c].data()[m]};
  };
  const auto takes = [&](int c, std::ptrdiff_t m) {
    return domain.boundaries.state(c).data()[m] == FaceState::kSolved && open.theta_f()[c].data()[m] > 0;
  };
  for (int c = 0; c < 3; ++c) {
    const std::ptrdiff_t s = body.stride(c);
    if (domain.solved[c])
      for_each(domain.faces[c], [&](int i, int j, int k) {
        const std::ptrdiff_t m = body.index(i, j, k);
        for (const std::ptrdiff_t cell : {m - s, m})
          if (body.data()[cell] >= 0 && takes(c, m)) faces_[c].push_back({m, int(body.data()[cell]), of_half(cell, c)});
      });
    for (const Cell& cell : cells_) {
      const Push half = of_half(cell.at, c);
      Sums& sum = sums_[cell.body];
      for (const std::ptrdiff_t face : {cell.at, cell.at + s}) {
        sum.all[c].square += half.square, sum.all[c].linear += half.linear;
        if (!domain.solved[c] || !takes(c, face)) sum.kept[c].square += half.square, sum.kept[c].linear += half.linear;
      }
    }
  }
}

/// Where the surface is, as seen from the cell's centre.
void Blowing::find_next(const FluidDomain& domain, const WallCell& wall, Cell& c) const {
  const OpenShares& open = *domain.measures.open();
  c.next = {c.at, c.at, c.at}, c.share = {0, 0, 0};
  for (int d = 0; d < 3; ++d) {
    const bool up = wall.area[d] > 0;
    const std::ptrdiff_t s = open.theta().stride(d), face = up ? c.at + s : c.at;
    if (wall.area[d] == 0 || !domain.solved[d] || domain.boundaries.state(d).data()[face] != FaceState::kSolved ||
        !(open.theta_f()[d].data()[face] > 0))
      continue;
    const Axis& axis = domain.grid.axis[d];
    double way = wall.point[d] - axis.centre(c.cell[d]);
    if (axis.periodic()) way -= axis.length() * std::round(way / axis.length());
    c.next[d] = up ? c.at + s : c.at - s;
    c.share[d] = way / (axis.centre(c.cell[d] + (up ? 1 : -1)) - axis.centre(c.cell[d]));
  }
}

void Blowing::add_pressure(const CellField<FineGrid>& p, double& of_pressure, double& of_area) const {
  for (const Cell& c : cells_) {
    double at = p.data()[c.at];
    for (int d = 0; d < 3; ++d) at += c.share[d] * (p.data()[c.next[d]] - p.data()[c.at]);
    of_pressure += at * c.size, of_area += c.size;
  }
}

bool Blowing::update(const FluidDomain& domain) {
  bool changed = !known_;
  known_ = true;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Blow& blow = bodies_[b].blow;
    if (!blow.on) continue;
    const double now = blow.velocity_now ? blow.velocity_now() : blow.velocity;
    changed = changed || now != velocity_[b];
    velocity_[b] = now;
  }
  if (!changed) return false;
  for (const Cell& c : cells_) rate_.data()[c.at] = velocity_[c.body] * c.size / c.volume;
  domain.fill(rate_);
  return true;
}

double Blowing::own_flow() const {
  double sum = 0;
  for (const Cell& c : cells_) sum += velocity_[c.body] * c.size;
  return sum;
}

void Blowing::add_momentum(double rho, FaceField<FineGrid>& out) const {
  for (int c = 0; c < 3; ++c)
    for (const OfFace& f : faces_[c]) out[c].data()[f.face] += f.push.at(rho, velocity_[f.body]);
}

void Blowing::take_off(CellField<FineGrid>& imbalance, double& sum, double& largest) const {
  for (const Cell& c : cells_) {
    const double flow = velocity_[c.body] * c.size;
    imbalance(c.cell[0], c.cell[1], c.cell[2]) -= flow;
    sum -= flow;
    largest = std::max(largest, velocity_[c.body]);
  }
}

}  // namespace twogrid
