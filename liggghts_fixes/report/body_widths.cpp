#include "liggghts_fixes/report/body_widths.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "liggghts_fixes/script/words.h"

namespace twogrid {

namespace {

constexpr int kLines = 48, kParts = 48;  // across a body; of a line, where the shape is asked at points
constexpr double kNone = 1e300;
constexpr double kMiddle = 0.35;  // of a part's length, that its middle lies from all surfaces at least
constexpr double kRoundness = 2.5, kSlope = 0.05, kTiny = 1e-6;
constexpr int kSide = -1;  // in place of a body

struct Crossing {
  double at;
  int body;
};

class Widths {
 public:
  Widths(const std::vector<Body>& bodies, const Grid& domain, const std::array<bool, 6>& walls,
         const std::vector<Vec3>& particles, double grain)
      : bodies_(bodies), walls_(walls), grain_(grain) {
    for (int d = 0; d < 3; ++d) lo_[d] = domain.axis[d].lo(), hi_[d] = domain.axis[d].hi();
    for (const Body& body : bodies) {
      knows_.push_back(body.shape->side({lo_[0], lo_[1], lo_[2]}) != SolidShape::Side::kUnknown);
      inside_is_fluid_.push_back(!knows_.back() && holds(body, particles));
    }
    for (std::size_t b = 0; b < bodies.size(); ++b) look_at(int(b));
  }

  std::vector<WidthAcross> found() const {
    std::vector<WidthAcross> all;
    for (const auto& [key, width] : least_) {
      const auto& [body, axis, what] = key;
      static const char* const kWhat[] = {", its diameter of ", ", its inner diameter of ", ", its thickness of ",
                                          ", the gap beside it of "};
      static const int kCells[] = {kCellsAcrossBody, kCellsAcrossBody, kCellsAcrossPlate, kCellsAcrossGap};
      WidthAcross w;
      w.name = "solid " + bodies_[body].name + kWhat[what] + brief(width) + " m along " + "xyz"[axis];
      w.size = {0, 0, 0};
      w.size[axis] = width, w.cells = kCells[what];
      all.push_back(w);
    }
    return all;
  }

  /// By some points of each layer.
  std::array<std::vector<double>, 3> open_layers(const Grid& domain) const {
    constexpr int kPoints = 24;  // in each direction
    std::array<std::vector<double>, 3> layers;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      const double area = (hi_[e] - lo_[e]) * (hi_[f] - lo_[f]);
      for (int i = 0; i < domain.axis[d].n(); ++i) {
        int open = 0;
        Vec3 x;
        x[d] = domain.axis[d].centre(i);
        for (int j = 0; j < kPoints * kPoints; ++j) {
          const int column = j % kPoints, row = j / kPoints;
          x[e] = lo_[e] + (column + 0.5) / kPoints * (hi_[e] - lo_[e]);
          x[f] = lo_[f] + (row + 0.5) / kPoints * (hi_[f] - lo_[f]);
          open += !solid(x, e);
        }
        layers[d].push_back(area * domain.axis[d].width(i) * open / (kPoints * kPoints));
      }
    }
    return layers;
  }

 private:
  enum What { kBody, kChannel, kPlate, kGap };

  /// Whether most of the particles lie within the surface; without any, whether it reaches to two sides of the domain.
  bool holds(const Body& body, const std::vector<Vec3>& particles) const {
    int in = 0;
    for (const Vec3& x : particles) in += odd_crossings(body, x, 0) && odd_crossings(body, x, 1);
    if (!particles.empty()) return 2 * in > int(particles.size());
    Vec3 from, to;
    body.shape->bounds(from, to);
    int reaches = 0;
    for (int d = 0; d < 3; ++d)
      reaches +=
          from[d] <= to[d] && from[d] < lo_[d] + 0.02 * (hi_[d] - lo_[d]) && to[d] > hi_[d] - 0.02 * (hi_[d] - lo_[d]);
    return reaches >= 2;
  }

  /// Of the ray from x upwards along d.
  bool odd_crossings(const Body& body, const Vec3& x, int d) const {
    Vec3 from, to;
    body.shape->bounds(from, to);
    double end = hi_[d];
    if (from[d] <= to[d]) end = std::max(end, to[d]) + 0.01 * (hi_[d] - lo_[d]);
    bool odd = false;
    Vec3 y = x;
    const double step = kTiny * (hi_[d] - lo_[d]);
    while (y[d] < end) {
      const double share = body.shape->first_crossing(y, d, end - y[d]);
      if (share >= SolidShape::kNone) break;
      odd = !odd, y[d] += share * (end - y[d]) + step;
    }
    return odd;
  }

  /// Where from x along d up to `end` (on either side of it) a surface is met first; kNone: nowhere.
  Crossing next(const Vec3& x, int d, double end) const {
    Crossing found{kNone, kSide};
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const int parts = knows_[b] ? kParts : 1;
      const double way = (end - x[d]) / parts;
      Vec3 y = x;
      for (int i = 0; i < parts; ++i) {
        y[d] = x[d] + i * way;
        if (std::abs(y[d] - x[d]) > std::abs(found.at - x[d])) break;
        const double share = bodies_[b].shape->first_crossing(y, d, way);
        if (share >= SolidShape::kNone) continue;
        const double at = y[d] + share * way;
        if (std::abs(at - x[d]) < std::abs(found.at - x[d])) found = {at, int(b)};
        break;
      }
    }
    return found;
  }

  bool solid(const Vec3& x, int d) const {
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (bodies_[b].sheet) continue;
      if (knows_[b]) {
        if (bodies_[b].shape->side(x) == SolidShape::Side::kSolid) return true;
      } else if (odd_crossings(bodies_[b], x, d) != inside_is_fluid_[b]) {
        return true;
      }
    }
    return false;
  }

  /// The part through x along d between two surfaces; of a side that is no wall nothing is known: kNone.
  double part(const Vec3& x, int d) const {
    double ends[2];
    for (bool up : {false, true}) {
      const double end = up ? hi_[d] : lo_[d];
      const Crossing c = next(x, d, end);
      if (c.at < kNone)
        ends[up] = c.at;
      else if (walls_[2 * d + up])
        ends[up] = end;
      else
        return kNone;
    }
    return ends[1] - ends[0];
  }

  /// Whether the part changes in one sense from line to line.
  bool slope(const Vec3& x, int d, double length, bool is_solid, const Vec3& spacing) const {
    for (int e = 0; e < 3; ++e) {
      if (e == d) continue;
      double change[2] = {0, 0};
      for (bool up : {false, true}) {
        Vec3 y = x;
        y[e] += up ? spacing[e] : -spacing[e];
        if (y[e] <= lo_[e] || y[e] >= hi_[e]) continue;
        const double beside = solid(y, d) == is_solid ? part(y, d) : 0;
        change[up] = std::min(beside, 1e3 * length) / length - 1;
      }
      if (std::min(change[0], change[1]) < -kSlope && std::max(change[0], change[1]) > kSlope) return true;
    }
    return false;
  }

  void look_at(int b) {
    Vec3 from, to;
    bodies_[b].shape->bounds(from, to);
    for (int d = 0; d < 3; ++d)
      if (from[d] > to[d]) from[d] = lo_[d], to[d] = hi_[d];
    Vec3 first, spacing;
    for (int d = 0; d < 3; ++d) {
      from[d] = std::max(from[d], lo_[d]), to[d] = std::min(to[d], hi_[d]);
      if (!(from[d] < to[d])) return;
      spacing[d] = (to[d] - from[d]) / kLines, first[d] = from[d] + 0.5 * spacing[d];
    }
    for (int d = 0; d < 3; ++d) {
      const int e = d == 0 ? 1 : 0, f = d == 2 ? 1 : 2;
      for (int j = 0; j < kLines; ++j)
        for (int i = 0; i < kLines; ++i) {
          Vec3 x = lo_;
          x[e] = first[e] + i * spacing[e], x[f] = first[f] + j * spacing[f];
          look_along(b, x, d, spacing);
        }
    }
  }

  void look_along(int b, Vec3 x, int d, const Vec3& spacing) {
    const double step = kTiny * (hi_[d] - lo_[d]);
    Crossing last{walls_[2 * d] ? lo_[d] : kNone, kSide};
    bool ends = false;
    while (!ends) {
      Crossing c = next(x, d, hi_[d]);
      ends = c.at >= kNone;
      if (ends && walls_[2 * d + 1]) c = {hi_[d], kSide};
      if (c.at < kNone && last.at < kNone && (c.body == b || last.body == b)) look_between(b, x, d, last, c, spacing);
      last = c;
      x[d] = c.at + step;
      ends = ends || x[d] >= hi_[d];
    }
  }

  void look_between(int b, Vec3 x, int d, const Crossing& from, const Crossing& to, const Vec3& spacing) {
    const double length = to.at - from.at;
    if (length < 10 * kTiny * (hi_[d] - lo_[d])) return;
    x[d] = 0.5 * (from.at + to.at);
    double room = length;
    Vec3 nearest;
    for (const Body& body : bodies_) room = std::min(room, body.shape->distance(x, 0.51 * length, nearest));
    for (int e = 0; e < 3; ++e) {
      if (walls_[2 * e]) room = std::min(room, x[e] - lo_[e]);
      if (walls_[2 * e + 1]) room = std::min(room, hi_[e] - x[e]);
    }
    if (room < kMiddle * length) return;
    const bool is_solid = solid(x, d);
    double across = kNone;
    for (int e = 0; e < 3; ++e)
      if (e != d) across = std::min(across, part(x, e));
    const bool round = across <= kRoundness * length;
    const What what = round ? (is_solid ? kBody : kChannel) : is_solid ? kPlate : kGap;
    if (!is_solid && length < grain_) return;
    const double width = length * length / (4 * room) + room;
    const auto known = least_.find({b, d, what});
    if (known != least_.end() && !(width < known->second * (1 - kTiny))) return;
    if (what == kPlate && !knows_[b] && outer_skin(b, d, x, from, to)) return;
    if (slope(x, d, length, is_solid, spacing)) return;
    least_[{b, d, what}] = width;
  }

  /// A vessel's wall of two surfaces: nothing more is met on one side, on the other its own other wall.
  bool outer_skin(int b, int d, Vec3 x, const Crossing& from, const Crossing& to) const {
    const double step = kTiny * (hi_[d] - lo_[d]);
    int meets[2];
    for (bool up : {false, true}) {
      x[d] = up ? to.at + step : from.at - step;
      const Crossing c = x[d] > lo_[d] && x[d] < hi_[d] ? next(x, d, up ? hi_[d] : lo_[d]) : Crossing{kNone, kSide};
      meets[up] = c.at < kNone && c.body == b;
    }
    return meets[0] != meets[1];
  }

  const std::vector<Body>& bodies_;
  std::array<bool, 6> walls_;
  double grain_;
  Vec3 lo_, hi_;
  std::vector<bool> knows_, inside_is_fluid_;
  std::map<std::tuple<int, int, What>, double> least_;  // body, along, what: m
};

}  // namespace

BodyMeasures measure_bodies(const std::vector<Body>& bodies, const Grid& domain, const std::array<bool, 6>& walls,
                            const std::vector<Vec3>& particles, double grain) {
  const Widths widths(bodies, domain, walls, particles, grain);
  return {widths.found(), widths.open_layers(domain)};
}

}  // namespace twogrid
