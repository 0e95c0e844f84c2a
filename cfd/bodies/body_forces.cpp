#include "cfd/bodies/body_forces.h"

#include <algorithm>
#include <cmath>

namespace twogrid {

namespace {

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

Vec3 BodyForce::torque_about(const Vec3& point) const {
  const Vec3 turn = cross({centre[0] - point[0], centre[1] - point[1], centre[2] - point[2]}, force());
  return {torque[0] + turn[0], torque[1] + turn[1], torque[2] + turn[2]};
}

BodyForces::BodyForces(const FluidDomain& domain, const CutLinks* cut) : domain_(domain) {
  const OpenShares* open = domain.measures.open();
  if (!open) return;
  int bodies = 0;
  for (const WallPiece& p : open->pieces()) bodies = std::max(bodies, p.body + 1);
  for (const WallCell& w : open->surface()) bodies = std::max(bodies, w.body + 1);
  MPI_Allreduce(MPI_IN_PLACE, &bodies, 1, MPI_INT, MPI_MAX, domain.comm);
  if (bodies == 0) return;
  force_.resize(bodies);
  find_centres(*open);
  find_walls(*open);
  for (const WallPiece& p : open->pieces()) {
    const std::ptrdiff_t m = open->theta().index(p.face[0], p.face[1], p.face[2]);
    const Vec3& centre = force_[p.body].centre;
    if (domain.boundaries.state(p.component).data()[m] == FaceState::kSolved &&
        open->theta_f()[p.component].data()[m] > 0)
      pieces_[p.component].push_back({m,
                                      p.body,
                                      p.conductance / open->theta_f()[p.component].data()[m],
                                      p.velocity,
                                      domain.measures.open_share_above(p.component, p.face[0], p.face[1], p.face[2]),
                                      {p.point[0] - centre[0], p.point[1] - centre[1], p.point[2] - centre[2]},
                                      int(&p - open->pieces().data())});
  }
  list_cells(*open);
  add_halves(*open);
  for (int c = 0; c < 3; ++c) {
    const std::vector<std::ptrdiff_t>& faces = open->without_convection(c);
    convection_to_[c] = bodies_near(c, faces);
    for_each(domain.faces[c], [&](int i, int j, int k) {
      const std::size_t q = volume_[c].size();
      if (q < faces.size() && body_.index(i, j, k) == faces[q])
        volume_[c].push_back(domain.measures.volume(c, i, j, k)),
            wall_velocity_[c].push_back(open->wall_velocity(c, faces[q]));
    });
    if (cut) stress_to_[c] = bodies_near(c, cut->faces(c));
  }
  body_ = {};
  for (auto& w : wall_) w = {};
}

void BodyForces::find_walls(const OpenShares& open) {
  body_.reset(domain_.local, -1.0);
  for (auto& w : wall_) w.reset(domain_.local);
  for (const WallCell& w : open.surface()) {
    body_(w.cell[0], w.cell[1], w.cell[2]) = w.body;
    for (int d = 0; d < 3; ++d) wall_[d](w.cell[0], w.cell[1], w.cell[2]) = w.point[d];
  }
  domain_.fill(body_);
  for (auto& w : wall_) domain_.fill(w);
}

/// Mean of the surfaces' points by area.
void BodyForces::find_centres(const OpenShares& open) {
  std::vector<double> sum(4 * force_.size(), 0.0);
  for (const WallCell& w : open.surface()) {
    const double A = std::sqrt(w.area[0] * w.area[0] + w.area[1] * w.area[1] + w.area[2] * w.area[2]);
    for (int d = 0; d < 3; ++d) sum[4 * w.body + d] += A * w.point[d];
    sum[4 * w.body + 3] += A;
  }
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), int(sum.size()), MPI_DOUBLE, MPI_SUM, domain_.comm);
  for (std::size_t b = 0; b < force_.size(); ++b)
    for (int d = 0; d < 3 && sum[4 * b + 3] > 0; ++d) force_[b].centre[d] = sum[4 * b + d] / sum[4 * b + 3];
}

void BodyForces::list_cells(const OpenShares& open) {
  for_each(domain_.own, [&](int i, int j, int k) {
    const Int3 x{i, j, k};
    const std::ptrdiff_t m = open.theta().index(i, j, k);
    Vec3 area{0, 0, 0};
    for (int d = 0; d < 3; ++d) {
      if (!domain_.solved[d]) continue;
      const auto share = [&](std::ptrdiff_t face) {
        return domain_.boundaries.state(d).data()[face] == FaceState::kSolved ? open.theta_f()[d].data()[face]
                                                                              : open.alpha(d, face);
      };
      area[d] = (share(m) - share(m + open.theta().stride(d))) * domain_.measures.area(d, i, j, k);
    }
    if (area[0] != 0 || area[1] != 0 || area[2] != 0) pressed_.push_back({m, body_near(-1, x), area});
  });
  for (const WallCell& w : open.surface()) {
    const Vec3& centre = force_[w.body].centre;
    const Vec3 arm{w.point[0] - centre[0], w.point[1] - centre[1], w.point[2] - centre[2]};
    walls_.push_back({open.theta().index(w.cell[0], w.cell[1], w.cell[2]), w.body,
                      cross(arm, {-w.area[0], -w.area[1], -w.area[2]})});
  }
}

/// Where the domain is periodic, for no mean gradient is imposed elsewhere.
void BodyForces::add_halves(const OpenShares& open) {
  halves_.resize(force_.size());
  for_each(domain_.own, [&](int i, int j, int k) {
    const double share = open.theta()(i, j, k);
    if (!(share > 0)) return;
    const double half = 0.5 * share * domain_.measures.cell_volume(i, j, k);
    for (int d = 0; d < 3; ++d)
      for (int up = 0; up < 2 && domain_.solved[d] && domain_.grid.axis[d].periodic(); ++up) {
        Int3 face{i, j, k};
        face[d] += up;
        if (open.alpha(d, open.theta().index(face[0], face[1], face[2])) > 0) continue;
        Vec3 point = force_[0].centre;
        const int body = body_near(d, face, &point);
        Halves& h = halves_[body];
        h.volume[d] += half;
        for (int e = 0; e < 3; ++e) h.arm[d][e] += half * (point[e] - force_[body].centre[e]);
      }
  });
}

/// Body whose surface is nearest to a face of the component, or (-1) to a cell, as the cells around hold points of it.
int BodyForces::body_near(int component, const Int3& x, Vec3* point) const {
  Box around;
  for (int d = 0; d < 3; ++d) around.lo[d] = x[d] - 2, around.hi[d] = x[d] + 3;
  double least = -1;
  int nearest = 0;
  for_each(intersect(around, body_.box()), [&](int i, int j, int k) {
    if (!(body_(i, j, k) >= 0)) return;
    double far = 0;
    Vec3 at;
    for (int d = 0; d < 3; ++d) {
      const Axis& axis = domain_.grid.axis[d];
      const double here = d == component ? axis.node(x[d]) : axis.centre(x[d]);
      double way = wall_[d](i, j, k) - here;
      if (axis.periodic()) way -= axis.length() * std::round(way / axis.length());
      far += way * way, at[d] = here + way;
    }
    if (least >= 0 && far >= least) return;
    least = far, nearest = int(body_(i, j, k));
    if (point) *point = at;
  });
  return nearest;
}

/// Of own faces of a component by memory index, ascending.
std::vector<BodyForces::Nearest> BodyForces::bodies_near(int c, const std::vector<std::ptrdiff_t>& faces) const {
  std::vector<Nearest> bodies;
  for_each(domain_.faces[c], [&](int i, int j, int k) {
    if (!(bodies.size() < faces.size() && body_.index(i, j, k) == faces[bodies.size()])) return;
    Nearest n{0, {0, 0, 0}};
    Vec3 point = force_[0].centre;
    n.body = body_near(c, {i, j, k}, &point);
    for (int d = 0; d < 3; ++d) n.arm[d] = point[d] - force_[n.body].centre[d];
    bodies.push_back(n);
  });
  return bodies;
}

void BodyForces::begin() {
  for (BodyForce& f : force_) {
    f.friction = f.pressure = f.convection = f.torque = f.carried = {0, 0, 0};
    f.blown = 0;
  }
}

void BodyForces::add_blown(double share, double rho) {
  const Blowing& blowing = *domain_.blowing;
  blowing.for_each_body(rho, [&](std::size_t b, const Vec3& carried, const Vec3& kept) {
    if (b >= force_.size()) return;
    force_[b].blown += share * blowing.velocity()[b] * blowing.area()[b];
    for (int d = 0; d < 3; ++d) force_[b].carried[d] += share * carried[d], force_[b].convection[d] += share * kept[d];
  });
}

void BodyForces::renew_walls() {
  const OpenShares& open = *domain_.measures.open();
  for (int c = 0; c < 3; ++c) {
    for (Piece& p : pieces_[c]) p.velocity = open.pieces()[p.piece].velocity;
    for (std::size_t q = 0; q < wall_velocity_[c].size(); ++q)
      wall_velocity_[c][q] = open.wall_velocity(c, open.without_convection(c)[q]);
  }
}

inline void BodyForces::add_friction(const Nearest& to, int c, double F) {
  BodyForce& f = force_[to.body];
  f.friction[c] += F;
  const int e = (c + 1) % 3, g = (c + 2) % 3;
  f.torque[e] += to.arm[g] * F, f.torque[g] -= to.arm[e] * F;
}

void BodyForces::add(double share, const FluidState& state, const Property& mu, const Lost& convection,
                     const Lost& stress, const Lost& exceeding, const Lost& drag, const Lost& pull) {
  const double* cell_mu = mu.varies() ? mu.field().data() : nullptr;
  for (int c = 0; c < 3; ++c) {
    const double *i_f = state.i_f[c].data(), *u = state.u[c].data();
    const std::ptrdiff_t s = state.p.stride(c);
    // Neighbours in the list are mostly of one body: its sums stay at hand as long as that is so.
    double friction = 0, along_g = 0, along_e = 0;
    int body = 0;
    const auto hand_over = [&] {
      BodyForce& f = force_[body];
      f.friction[c] += friction, f.torque[(c + 1) % 3] += along_g, f.torque[(c + 2) % 3] -= along_e;
      friction = along_g = along_e = 0;
    };
    const int e = (c + 1) % 3, g = (c + 2) % 3;
    const double same = share * mu.number;
    for (const Piece& p : pieces_[c]) {
      if (p.body != body) hand_over(), body = p.body;
      const double viscosity =
          cell_mu ? share * (cell_mu[p.face - s] + p.above * (cell_mu[p.face] - cell_mu[p.face - s])) : same;
      const double F = viscosity * p.conductance * i_f[p.face] * (u[p.face] - p.velocity);
      friction += F, along_g += p.arm[g] * F, along_e += p.arm[e] * F;
    }
    hand_over();
  }
  const auto by_body = [&](const auto& list, auto&& of, auto&& total) {
    Vec3 sum{0, 0, 0};
    int body = 0;
    const auto hand_over = [&] {
      for (int d = 0; d < 3; ++d) total(force_[body])[d] += sum[d];
      sum = {0, 0, 0};
    };
    for (const auto& entry : list) {
      if (entry.body != body) hand_over(), body = entry.body;
      const double p = share * state.p.data()[entry.cell];
      const Vec3& factor = of(entry);
      sum[0] += p * factor[0], sum[1] += p * factor[1], sum[2] += p * factor[2];
    }
    hand_over();
  };
  by_body(
      pressed_, [](const Pressed& c) -> const Vec3& { return c.area; },
      [](BodyForce& f) -> Vec3& { return f.pressure; });
  by_body(
      walls_, [](const Wall& w) -> const Vec3& { return w.turning; }, [](BodyForce& f) -> Vec3& { return f.torque; });
  for (std::size_t b = 0; b < halves_.size(); ++b)
    for (int c = 0; c < 3; ++c) {
      const double G = share * state.imposed[c];
      const int e = (c + 1) % 3, g = (c + 2) % 3;
      force_[b].pressure[c] -= G * halves_[b].volume[c];
      force_[b].torque[e] -= G * halves_[b].arm[c][g], force_[b].torque[g] += G * halves_[b].arm[c][e];
    }
  for (int c = 0; c < 3; ++c) {
    const std::ptrdiff_t* faces = domain_.measures.open()->without_convection(c).data();
    const bool friction = drag[c].size() == convection[c].size(), pulled = pull[c].size() == convection[c].size();
    for (std::size_t q = 0; q < convection[c].size(); ++q) {
      double F = convection[c][q];
      if (friction && drag[c][q] != 0)
        F += drag[c][q] * state.i_f[c].data()[faces[q]] * volume_[c][q] *
             (state.u[c].data()[faces[q]] - wall_velocity_[c][q]);
      if (F != 0) force_[convection_to_[c][q].body].convection[c] += share * F;
      if (pulled && pull[c][q] != 0) add_friction(convection_to_[c][q], c, -share * pull[c][q]);
    }
    for (std::size_t q = 0; q < stress[c].size(); ++q) {
      if (exceeding[c][q] == 0) {
        force_[stress_to_[c][q].body].friction[c] += share * stress[c][q];
        continue;
      }
      force_[stress_to_[c][q].body].friction[c] += share * (stress[c][q] - exceeding[c][q]);
      add_friction(stress_to_[c][q], c, share * exceeding[c][q]);
    }
  }
}

void BodyForces::end() {
  std::vector<double> sum;
  for (const BodyForce& f : force_)
    for (const Vec3* v : {&f.friction, &f.pressure, &f.convection, &f.torque})
      sum.insert(sum.end(), v->begin(), v->end());
  if (sum.empty()) return;
  if (domain_.blowing)
    for (const BodyForce& f : force_) sum.insert(sum.end(), f.carried.begin(), f.carried.end());
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), int(sum.size()), MPI_DOUBLE, MPI_SUM, domain_.comm);
  const double* s = sum.data();
  for (BodyForce& f : force_)
    for (Vec3* v : {&f.friction, &f.pressure, &f.convection, &f.torque})
      for (double& x : *v) x = *s++;
  if (!domain_.blowing) return;
  for (BodyForce& f : force_)
    for (double& x : f.carried) x = *s++;
}

}  // namespace twogrid
