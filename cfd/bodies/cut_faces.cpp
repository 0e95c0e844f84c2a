#include "cfd/bodies/cut_faces.h"

#include <algorithm>

namespace twogrid {

namespace {

using Point = std::array<double, 2>;

/// Area and first moments of a polygon, added to sums.
void add_polygon(const Point* p, int n, double (&sum)[3]) {
  for (int q = 0; q < n; ++q) {
    const Point &a = p[q], &b = p[(q + 1) % n];
    const double twice = a[0] * b[1] - b[0] * a[1];
    sum[0] += 0.5 * twice;
    for (int m = 0; m < 2; ++m) sum[1 + m] += (a[m] + b[m]) * twice / 6;
  }
}

constexpr unsigned kAround[4] = {0, 1, 3, 2};  // corners one after the other
constexpr Point kCorner[4] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
constexpr double kAtEnd = 1 - 2 * LocalGrid::kOn;

}  // namespace

VertexKind CutFaces::corner(int d, const Int3& face, unsigned q) const {
  Int3 v = face;
  v[(d + 1) % 3] += q & 1, v[(d + 2) % 3] += q >> 1;
  return vertices_(v[0], v[1], v[2]);
}

double CutFaces::reach(int d, const Int3& low, bool from_high) const {
  const Crossing* c = edges_.at(d, low[0], low[1], low[2]);
  return !c ? 1.0 : from_high ? c->high : c->low;
}

CutFaces::Outline CutFaces::outline(int d, const Int3& face) const {
  Outline out;
  VertexKind kind[4];
  int fluid = 0, solid = 0;
  for (unsigned q = 0; q < 4; ++q) {
    kind[q] = corner(d, face, q);
    fluid += kind[q] == VertexKind::kFluid, solid += kind[q] == VertexKind::kSolid;
  }
  if (fluid == 0) return out;
  bool at_ends = solid == 0;
  const auto put = [&](const Point& p, unsigned from, unsigned to) {
    out.point[out.n] = p;
    out.from[out.n] = static_cast<unsigned char>(from), out.to[out.n] = static_cast<unsigned char>(to);
    ++out.n;
  };
  const auto crossing = [&](unsigned from, unsigned to) {
    const int along = (from ^ to) == 1 ? 0 : 1;  // edge in the first or in the second direction
    Int3 low = face;
    low[(d + 2 - along) % 3] += along == 0 ? int(from >> 1) : int(from & 1);
    const bool from_high = kCorner[from][along] > kCorner[to][along];
    const double way = reach((d + 1 + along) % 3, low, from_high);
    at_ends = at_ends && way >= kAtEnd;
    Point p = kCorner[from];
    p[along] = from_high ? 1 - way : way;
    put(p, from, to);
  };
  for (int a = 0; a < 4; ++a) {
    const unsigned here = kAround[a], before = kAround[(a + 3) % 4], after = kAround[(a + 1) % 4];
    if (kind[here] != VertexKind::kFluid) continue;
    if (kind[before] != VertexKind::kFluid) crossing(here, before);
    put(kCorner[here], here, here);
    if (kind[after] != VertexKind::kFluid) crossing(here, after);
  }
  out.whole = fluid == 4 || at_ends;
  // Two corners that the solid between them parts.
  out.parted = !out.whole && fluid == 2 && kind[0] == kind[3] && !fluid_centre(d, face);
  return out;
}

CutFaces::Open CutFaces::open(int d, const Int3& face) const {
  const Outline around = outline(d, face);
  if (around.n == 0) return {};
  if (around.whole) return {1, {0.5, 0.5}};
  double sum[3] = {0, 0, 0};
  const int each = around.parted ? 3 : around.n;
  for (int first = 0; first < around.n; first += each) add_polygon(around.point.data() + first, each, sum);
  if (!(sum[0] > 0)) return {};
  const double share = std::min(sum[0], 1.0);
  return {share, {sum[1] / sum[0], sum[2] / sum[0]}};
}

bool CutFaces::fluid_centre(int d, const Int3& face) const {
  unsigned fluid = 0;
  for (unsigned q = 0; q < 4; ++q)
    if (corner(d, face, q) == VertexKind::kFluid) fluid |= 1u << q;
  if (fluid == 15 || fluid == 0) return fluid != 0;
  return (edges_.joined_corners(d, face) & fluid) != 0;
}

bool CutFaces::aligned(const Int3& cell) const {
  for (int d = 0; d < 3; ++d)
    for (int q = 0; q < 4; ++q) {
      Int3 low = cell;
      low[(d + 1) % 3] += q & 1, low[(d + 2) % 3] += q >> 1;
      Int3 high = low;
      ++high[d];
      const VertexKind a = vertices_(low[0], low[1], low[2]), b = vertices_(high[0], high[1], high[2]);
      if (a == VertexKind::kSolid || b == VertexKind::kSolid) return false;
      if (a == VertexKind::kFluid && b != a && reach(d, low, false) < kAtEnd) return false;
      if (b == VertexKind::kFluid && a != b && reach(d, low, true) < kAtEnd) return false;
    }
  return true;
}

double CutFaces::open_share(const Int3& cell, const FaceField<FineGrid>& alpha) const {
  Vec3 sum{0, 0, 0};
  int points = 0, fluid = 0;
  for (int d = 0; d < 3; ++d)
    for (int q = 0; q < 4; ++q) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      Int3 low = cell;
      low[e] += q & 1, low[f] += q >> 1;
      Int3 high = low;
      ++high[d];
      const bool a = vertices_(low[0], low[1], low[2]) == VertexKind::kFluid,
                 b = vertices_(high[0], high[1], high[2]) == VertexKind::kFluid;
      fluid += int(a) + int(b);
      if (a == b) continue;
      const double way = reach(d, low, b);
      sum[d] += a ? way : 1 - way, sum[e] += q & 1, sum[f] += q >> 1;
      ++points;
    }
  if (fluid == 0) return 0;
  if (points == 0 || aligned(cell)) return 1;
  double share = 0;
  for (int d = 0; d < 3; ++d) {
    Int3 above = cell;
    ++above[d];
    const double c = sum[d] / points;
    share += c * alpha[d](cell[0], cell[1], cell[2]) + (1 - c) * alpha[d](above[0], above[1], above[2]);
  }
  return std::min(share / 3, 1.0);
}

}  // namespace twogrid
