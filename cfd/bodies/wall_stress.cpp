#include "cfd/bodies/wall_stress.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>

#include "cfd/bodies/wall_fit.h"

namespace twogrid {

namespace {

constexpr double kFar = 2.6;  // cells: nothing farther away has a part in a fit of velocities
constexpr int kWide = 3;      // cells to either side that pressures come from: three layers before any facet

double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3 less(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double size_of(const Vec3& a) {
  return std::sqrt(dot(a, a));
}
Vec3 unit(const Vec3& a) {
  const double all = size_of(a);
  return {a[0] / all, a[1] / all, a[2] / all};
}

/// Mean of the triangles between the corners and their mean, by area.
Vec3 centre_of(const std::vector<Vec3>& corners) {
  Vec3 mean{0, 0, 0}, sum{0, 0, 0};
  for (const Vec3& p : corners)
    for (int d = 0; d < 3; ++d) mean[d] += p[d] / double(corners.size());
  double area = 0;
  for (std::size_t q = 0; q < corners.size(); ++q) {
    const Vec3 &a = corners[q], &b = corners[(q + 1) % corners.size()];
    const double A = size_of(cross(less(a, mean), less(b, mean)));
    area += A;
    for (int d = 0; d < 3; ++d) sum[d] += A * (mean[d] + a[d] + b[d]) / 3;
  }
  if (!(area > 0)) return mean;
  for (double& s : sum) s /= area;
  return sum;
}

/// Of a place so many cells away, squared; the fewer cells `width`, the more the nearest ones count.
double weight_at(double far2, double width) {
  return std::exp(-far2 / (2 * width * width));
}

/// Cells of a block that open faces join to one of them: open(d, face).
template <class Open>
std::vector<Int3> reached_from(const Int3& cell, const Box& block, Open&& open) {
  Array3<char> known(block, 0);
  std::vector<Int3> found{cell};
  known(cell[0], cell[1], cell[2]) = 1;
  for (std::size_t q = 0; q < found.size(); ++q)
    for (int d = 0; d < 3; ++d)
      for (bool up : {false, true}) {
        Int3 next = found[q];
        next[d] += up ? 1 : -1;
        if (!block.contains(next[0], next[1], next[2]) || known(next[0], next[1], next[2])) continue;
        if (!open(d, up ? next : found[q])) continue;
        known(next[0], next[1], next[2]) = 1;
        found.push_back(next);
      }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

/// Where the surfaces are, as seen from cells and faces of a grid, each asked but once.
class WallStress::Feet {
 public:
  Feet(const FineGrid& grid, const std::vector<Body>& bodies) : grid_(grid), surfaces_(grid, bodies) {}

  bool slips(const Surfaces::Foot& foot) const { return surfaces_.bodies()[foot.body].slip; }
  /// Of the foot's body, at any place as a rigid body's, m/s.
  Vec3 wall_velocity(const Surfaces::Foot& foot, const Vec3& x) const {
    return surfaces_.bodies()[foot.body].motion.at(x);
  }
  /// Whether the body of a foot blows there.
  bool blows(const Surfaces::Foot& foot) const {
    const Blow& blow = surfaces_.bodies()[foot.body].blow;
    Vec3 point = foot.point;
    for (int d = 0; d < 3; ++d) point[d] -= foot.shift[d];
    return blow.on && (!blow.where || blow.where(point));
  }
  bool any_blows() const {
    return std::any_of(surfaces_.bodies().begin(), surfaces_.bodies().end(), [](const Body& b) { return b.blow.on; });
  }
  /// Of a cell's centre (component -1) or a face's; beyond periodic sides not wrapped.
  Vec3 position(const Int3& x, int component) const {
    Vec3 at;
    for (int d = 0; d < 3; ++d) at[d] = d == component ? grid_.axis[d].node(x[d]) : grid_.axis[d].centre(x[d]);
    return at;
  }
  /// As Surfaces::nearest, of a place that may lie beyond a periodic side.
  Surfaces::Foot nearest(const Vec3& x, double reach) const {
    Vec3 inside = x, by{0, 0, 0};
    for (int d = 0; d < 3; ++d) {
      const Axis& axis = grid_.axis[d];
      if (axis.periodic()) by[d] = axis.length() * std::floor((x[d] - axis.lo()) / axis.length());
      inside[d] -= by[d];
    }
    Surfaces::Foot foot = surfaces_.nearest(inside, reach);
    for (int d = 0; d < 3; ++d) foot.point[d] += by[d];
    return foot;
  }
  /// m: the face's memory index. There must be a surface within reach.
  const Surfaces::Foot& of_face(int c, const Int3& face, std::ptrdiff_t m, double reach) {
    const auto found = known_[c].find(m);
    if (found != known_[c].end()) return found->second;
    return known_[c].emplace(m, nearest(position(face, c), reach)).first->second;
  }

 private:
  const FineGrid& grid_;
  const Surfaces surfaces_;
  std::array<std::unordered_map<std::ptrdiff_t, Surfaces::Foot>, 3> known_;
};

WallStress::WallStress(const FluidDomain& domain, const std::vector<Body>& bodies, const FluidState& state,
                       const Property& viscosity)
    : domain_(domain), state_(state), viscosity_(viscosity), bodies_(bodies.size()) {
  Int3 halo;
  for (int d = 0; d < 3; ++d) halo[d] = domain.solved[d] ? kWide : 0;
  const std::vector<Box> wide = with_halo(domain.layout.all_cells(), halo);
  wide_ = BlockExchange(domain.comm, domain.layout.all_cells(), wide, domain.grid.n(), domain.grid.periodic());
  p_.reset(wide[domain.rank]);
  Wide shares;
  shares.theta.reset(p_.box());
  for (auto& open : shares.open) open.reset(p_.box());
  const OpenShares& open = *domain.measures.open();
  for_each(domain.own, [&](int i, int j, int k) {
    const std::ptrdiff_t m = open.theta().index(i, j, k);
    shares.theta(i, j, k) = open.theta().data()[m];
    for (int d = 0; d < 3; ++d) shares.open[d](i, j, k) = open.alpha(d, m);
  });
  wide_.bring<double>(std::vector<Array3<double>*>{&shares.theta, &shares.open[0], &shares.open[1], &shares.open[2]});
  list_facets(bodies);
  Feet feet(domain.grid, bodies);
  for (std::size_t q = 0; q < facets_.size(); ++q) {
    const Place place = place_of(facets_[q], feet);
    const std::vector<Int3> cells = reached_from(
        place.cell, around(place.cell, 2, domain.local),
        [&](int d, const Int3& face) { return open.alpha(d, open.theta().index(face[0], face[1], face[2])) > 0; });
    of_wall_.push_back({0, 0, 0});
    normal_.push_back(place.normal);
    for (int c = 0; c < 3; ++c) {
      if (domain.solved[c] && !slip_[q]) fit_friction(place, cells, feet, c);
      slope_[c].begin.push_back(slope_[c].list.size());
    }
    fit_pressure(place, shares, feet);
    pressure_.begin.push_back(pressure_.list.size());
  }
}

void WallStress::list_facets(const std::vector<Body>& bodies) {
  const OpenShares& open = *domain_.measures.open();
  for (std::size_t q = 0; q < open.surface().size(); ++q) {
    const WallCell& w = open.surface()[q];
    const double all = size_of(w.area);
    if (!(all > 0)) continue;
    WallFacet f;
    f.body = w.body, f.cell = w.cell;
    f.corners = open.outlines()[q];
    f.centre = f.corners.empty() ? w.point : centre_of(f.corners);
    f.normal = unit(w.area);
    // Of a cell that is open all through, walls lie in its sides; a sheet's steps there stand for a slope.
    const bool in_sides = !(open.theta()(w.cell[0], w.cell[1], w.cell[2]) < 1) && !bodies[w.body].sheet;
    f.area = in_sides ? std::abs(w.area[0]) + std::abs(w.area[1]) + std::abs(w.area[2]) : all;
    facets_.push_back(f);
    area_.push_back(w.area);
    slip_.push_back(bodies[w.body].slip);
  }
}

WallStress::Place WallStress::place_of(const WallFacet& facet, const Feet& feet) const {
  Place p;
  p.cell = facet.cell, p.point = facet.centre, p.normal = facet.normal;
  for (int d = 0; d < 3; ++d) p.width[d] = domain_.grid.axis[d].width(facet.cell[d]);
  const auto across = [&](const Vec3& n) {
    double sum = 0;
    for (int d = 0; d < 3; ++d) sum += n[d] * n[d] / (p.width[d] * p.width[d]);
    return 1 / std::sqrt(sum);
  };
  // The normal of small facets hangs on few digits; the surface itself knows better, unless another part of it is as near.
  const double step = 0.5 * across(facet.normal);
  const Surfaces::Foot at = feet.nearest(facet.centre, 2 * step);
  if (at.body >= 0) p.point = at.point;
  for (int pass = 0; pass < 2; ++pass) {
    Vec3 before = p.point;
    for (int d = 0; d < 3; ++d) before[d] += step * p.normal[d];
    const Surfaces::Foot foot = feet.nearest(before, 4 * step);
    if (foot.body < 0 || foot.distance < 0.1 * step) break;
    const Vec3 n = unit(less(before, foot.point));
    if (!(dot(n, facet.normal) > 0.5)) break;
    p.normal = n;
  }
  p.across = across(p.normal);
  int least = 0;
  for (int d = 1; d < 3; ++d)
    if (std::abs(p.normal[d]) < std::abs(p.normal[least])) least = d;
  Vec3 axis{0, 0, 0};
  axis[least] = 1;
  p.along[0] = unit(cross(p.normal, axis)), p.along[1] = cross(p.normal, p.along[0]);
  for (Vec3& t : p.along) {
    const double width = across(t);
    for (double& x : t) x /= width;
  }
  return p;
}

/// The cells so many away that are in a box and in the domain.
Box WallStress::around(const Int3& cell, int cells, const Box& within) const {
  Box block{cell, {cell[0] + 1, cell[1] + 1, cell[2] + 1}};
  block = intersect(block.grown(cells), within);
  for (int d = 0; d < 3; ++d) {
    const Axis& axis = domain_.grid.axis[d];
    if (!axis.periodic()) block.lo[d] = std::max(block.lo[d], 0), block.hi[d] = std::min(block.hi[d], axis.n());
  }
  return block;
}

void WallStress::fit_friction(const Place& place, const std::vector<Int3>& cells, Feet& feet, int c) {
  const OpenShares& open = *domain_.measures.open();
  std::set<Int3> faces;
  for (const Int3& x : cells)
    for (bool up : {false, true}) {
      Int3 face = x;
      face[c] += up;
      // Two cells on both sides of the facet's: in the halo of any rank.
      if (face[c] > place.cell[c] - 2 && face[c] < place.cell[c] + 3) faces.insert(face);
    }
  WallFit fit(10);
  std::vector<Weight> found;
  std::vector<double> wall;
  const std::size_t first_blown = blown_.size();
  const bool any_blows = feet.any_blows();
  for (const Int3& x : faces) {
    const std::ptrdiff_t m = open.theta().index(x[0], x[1], x[2]);
    if (domain_.boundaries.state(c).data()[m] != FaceState::kSolved || !(open.theta_f()[c].data()[m] > 0) ||
        open.sliver(c, m))
      continue;
    const Vec3 here = feet.position(x, c);
    double far2 = 0;
    for (int d = 0; d < 3; ++d) far2 += std::pow((here[d] - place.point[d]) / place.width[d], 2);
    if (far2 > kFar * kFar) continue;
    const Surfaces::Foot& foot = feet.of_face(c, x, m, kFar * (place.width[0] + place.width[1] + place.width[2]));
    if (foot.body < 0 || feet.slips(foot) || foot.distance < 1e-3 * place.across) continue;
    const Vec3 out = less(here, foot.point);
    if (!(dot(out, place.normal) > 0.5 * foot.distance)) continue;
    const Vec3 way = less(foot.point, place.point);
    const double n = foot.distance / place.across, s = dot(way, place.along[0]), t = dot(way, place.along[1]);
    fit.add(weight_at(far2, 0.9),
            {n, n * s, n * t, n * n, n * s * s, n * s * t, n * t * t, n * n * s, n * n * t, n * n * n});
    found.push_back({m, open.centre(c, m)});
    wall.push_back(feet.wall_velocity(foot, here)[c] - open.drift(c, m));
    if (any_blows)
      blown_.push_back({of_wall_.size() - 1, c, foot.body, m, 0, feet.wall_velocity(foot, here)[c],
                        feet.blows(foot) ? out[c] / foot.distance : 0.0});
  }
  const std::vector<double> weights = fit.of_first(1e-8);
  for (std::size_t q = 0; q < found.size(); ++q) {
    const double w = weights[q] / place.across;
    slope_[c].list.push_back({found[q].at, w * found[q].weight});
    of_wall_.back()[c] += w * wall[q];
    if (any_blows) blown_[first_blown + q].weight = w;
  }
}

void WallStress::renew_walls(const std::vector<double>& velocity) {
  const OpenShares& open = *domain_.measures.open();
  for (const OfWall& w : blown_) of_wall_[w.facet][w.component] = 0;
  for (const OfWall& w : blown_)
    of_wall_[w.facet][w.component] +=
        w.weight * (w.at_rest + velocity[w.body] * w.share - open.drift(w.component, w.face));
}

void WallStress::fit_pressure(const Place& place, const Wide& shares, const Feet& feet) {
  const std::vector<Int3> cells =
      reached_from(place.cell, around(place.cell, kWide, p_.box()),
                   [&](int d, const Int3& face) { return shares.open[d](face[0], face[1], face[2]) > 0; });
  for (double least_open : {0.5, 0.0}) {
    WallFit fit(10);
    std::vector<std::ptrdiff_t> found;
    for (const Int3& x : cells) {
      Vec3 r = less(feet.position(x, -1), place.point);
      const double ahead = dot(r, place.normal);
      if (!(shares.theta(x[0], x[1], x[2]) >= least_open) || (least_open > 0 && !(ahead > 0))) continue;
      for (int d = 0; d < 3; ++d) r[d] /= place.width[d];
      if (dot(r, r) > 12) continue;
      fit.add(weight_at(dot(r, r), 0.65),
              {1, r[0], r[1], r[2], r[0] * r[0], r[1] * r[1], r[2] * r[2], r[0] * r[1], r[1] * r[2], r[2] * r[0]});
      found.push_back(p_.index(x[0], x[1], x[2]));
    }
    if (found.empty()) continue;
    const std::vector<double> weights = fit.of_first(1e-9);
    for (std::size_t q = 0; q < found.size(); ++q) pressure_.list.push_back({found[q], weights[q]});
    return;
  }
}

void WallStress::take(const CellField<FineGrid>& p) {
  for_each(domain_.own, [&](int i, int j, int k) { p_(i, j, k) = p(i, j, k); });
  wide_.bring<double>(p_);
}

Vec3 WallStress::slope(std::size_t facet, const FaceField<FineGrid>& u) const {
  Vec3 slope;
  for (int c = 0; c < 3; ++c) slope[c] = slope_[c].sum(facet, u[c].data()) - of_wall_[facet][c];
  return slope;
}

Vec3 WallStress::friction(std::size_t facet) const {
  const WallFacet& f = facets_[facet];
  const std::ptrdiff_t m = state_.p.index(f.cell[0], f.cell[1], f.cell[2]);
  const double mu = viscosity_.varies() ? viscosity_.field().data()[m] : viscosity_.number;
  Vec3 t = slope(facet, state_.u);
  const Vec3& n = normal_[facet];
  const double through = dot(t, n);
  for (int d = 0; d < 3; ++d) t[d] = mu * state_.eps_open.data()[m] * (t[d] - through * n[d]);
  return t;
}

std::vector<std::array<Vec3, 2>> WallStress::sums() const {
  std::vector<std::array<Vec3, 2>> sum(bodies_, {Vec3{0, 0, 0}, Vec3{0, 0, 0}});
  for (std::size_t q = 0; q < facets_.size(); ++q) {
    const Vec3 t = friction(q);
    const double p = pressure(q);
    for (int d = 0; d < 3; ++d)
      sum[facets_[q].body][0][d] += facets_[q].area * t[d], sum[facets_[q].body][1][d] -= p * area_[q][d];
  }
  if (!sum.empty()) MPI_Allreduce(MPI_IN_PLACE, sum.data(), int(6 * sum.size()), MPI_DOUBLE, MPI_SUM, domain_.comm);
  return sum;
}

}  // namespace twogrid
