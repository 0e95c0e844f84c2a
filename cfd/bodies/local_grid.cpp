#include "cfd/bodies/local_grid.h"

#include "cfd/boundary/patches.h"
#include "cfd/parallel/ranks.h"

namespace twogrid {

namespace {

bool lets_pass(const BoundaryCondition& c) {
  return c.kind == BoundaryKind::kInlet || c.kind == BoundaryKind::kPressure;
}

std::array<bool, 3> solved_directions(const FineGrid& grid, const FluidSettings& settings) {
  std::array<bool, 3> solved{true, true, true};
  for (int d = 0; d < 3; ++d) {
    if (grid.axis[d].n() > 1 || grid.axis[d].periodic()) continue;
    solved[d] = false;
    for (int side : {2 * d, 2 * d + 1})
      for (const BoundaryCondition& c : settings.side[side]) solved[d] = solved[d] || lets_pass(c);
  }
  return solved;
}

Box around(const Grid& grid, Box own) {
  if (own.empty()) return own;
  for (int d = 0; d < 3; ++d) {
    const bool periodic = grid.axis[d].periodic();
    if (periodic || own.lo[d] > 0) --own.lo[d];
    if (periodic || own.hi[d] < grid.axis[d].n()) ++own.hi[d];
  }
  return own;
}

Box corners(Box cells) {
  if (!cells.empty())
    for (int& h : cells.hi) ++h;
  return cells;
}

Box own_corners(const Grid& grid, Box own) {
  if (!own.empty())
    for (int d = 0; d < 3; ++d)
      if (!grid.axis[d].periodic() && own.hi[d] == grid.axis[d].n()) ++own.hi[d];
  return own;
}

Box faces_of(Box cells, int d) {
  if (!cells.empty()) ++cells.hi[d];
  return cells;
}

template <class F>
std::vector<Box> of_all(const Layout& layout, F&& f) {
  std::vector<Box> all = layout.all_cells();
  for (Box& b : all) b = f(b);
  return all;
}

}  // namespace

LocalGrid::LocalGrid(MPI_Comm c, const FineGrid& g, const Layout& layout, const FluidSettings& s)
    : comm(c),
      grid(g),
      settings(s),
      own(layout.cells(rank_of(c))),
      cells(around(g, own)),
      own_vertices(own_corners(g, own)),
      vertices(corners(cells)),
      own_faces{layout.faces(0, rank_of(c)), layout.faces(1, rank_of(c)), layout.faces(2, rank_of(c))},
      faces{faces_of(cells, 0), faces_of(cells, 1), faces_of(cells, 2)},
      solved(solved_directions(g, s)),
      vertex_halo(c, of_all(layout, [&](const Box& b) { return own_corners(g, b); }),
                  of_all(layout, [&](const Box& b) { return corners(around(g, b)); }), g.n(), g.periodic()),
      cell_halo(c, layout.all_cells(), of_all(layout, [&](const Box& b) { return around(g, b); }), g.n(), g.periodic()),
      face_halo(c, {layout.all_faces(0), layout.all_faces(1), layout.all_faces(2)},
                {of_all(layout, [&](const Box& b) { return faces_of(around(g, b), 0); }),
                 of_all(layout, [&](const Box& b) { return faces_of(around(g, b), 1); }),
                 of_all(layout, [&](const Box& b) { return faces_of(around(g, b), 2); })},
                g.n(), g.periodic()),
      n_(g.n()),
      periodic_(g.periodic()) {
  if (own.empty()) return;
  for (int d = 0; d < 3; ++d) {
    const Axis& axis = grid.axis[d];
    Coordinates& at = axis_[d];
    for (int i = cells.lo[d]; i <= cells.hi[d]; ++i) {
      const int in = wrap(d, i), last = std::min(in, n_[d] - 1);
      at.node.push_back(axis.node(in));
      at.width.push_back(axis.width(last));
      double inwards = 0;
      if (!periodic_[d] && in == 0) inwards = kInwards * axis.width(0);
      if (!periodic_[d] && in == n_[d]) inwards = -kInwards * axis.width(last);
      at.inner_node.push_back(axis.node(in) + inwards);
    }
  }
}

Vec3 LocalGrid::face_centre(int d, const Int3& c) const {
  Vec3 x;
  for (int e = 0; e < 3; ++e) x[e] = e == d ? inner_node(e, c[e]) : centre(e, c[e]);
  return x;
}

int LocalGrid::condition(int side, const Int3& face) const {
  Vec3 x;
  const int d = direction(side);
  for (int e = 0; e < 3; ++e) x[e] = e == d ? node(e, face[e]) : grid.axis[e].centre(wrap(e, face[e]));
  const auto& conditions = settings.side[side];
  for (int c = int(conditions.size()) - 1; c > 0; --c)
    if (covers(conditions[c].shape, side, x)) return c;
  return 0;
}

bool LocalGrid::passes(int side, const Int3& face) const {
  const auto& conditions = settings.side[side];
  return !conditions.empty() && lets_pass(conditions[condition(side, face)]);
}

}  // namespace twogrid
