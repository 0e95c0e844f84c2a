#include "cfd/bodies/wall_outlines.h"

namespace twogrid {

namespace {

/// The edges of the polygons around a cell's open part, by points with a number each: the cell's corners (bits: their
/// places in x, y, z) and the crossings of its edges (8, then the edge's direction and low corner).
class Polygons {
 public:
  static constexpr int kPoints = 32;
  Polygons(const LocalGrid& grid, const Int3& cell) : grid_(grid), cell_(cell) {}

  void add(const CutFaces::Outline& around, int first, int each, int d, bool high) {
    for (int q = 0; q < each; ++q) {
      const int a = point(around, first + q, d, high), b = point(around, first + (q + 1) % each, d, high);
      high ? put(a, b) : put(b, a);  // seen from outside
    }
  }
  void add_whole(int d, bool high) {
    constexpr unsigned kAround[4] = {0, 1, 3, 2};
    for (int q = 0; q < 4; ++q) {
      const int a = corner(kAround[q], d, high), b = corner(kAround[(q + 1) % 4], d, high);
      high ? put(a, b) : put(b, a);
    }
  }
  /// Lines of edges that no other polygon shares, one behind the other.
  std::vector<Vec3> open_line() const {
    std::vector<Vec3> line;
    std::vector<Edge> left = edges_;
    while (!left.empty()) {
      const int start = left.back().from;
      int at = start;
      do {
        std::size_t q = 0;
        while (q < left.size() && left[q].from != at) ++q;
        if (q == left.size()) break;
        line.push_back(place_[at]);
        at = left[q].to;
        left.erase(left.begin() + std::ptrdiff_t(q));
      } while (at != start);
      if (!left.empty()) line.push_back(place_[start]);  // back, and on to the next
    }
    return line;
  }

 private:
  struct Edge {
    int from, to;
  };
  void put(int a, int b) {
    for (std::size_t q = 0; q < edges_.size(); ++q)
      if (edges_[q].from == b && edges_[q].to == a) {
        edges_.erase(edges_.begin() + std::ptrdiff_t(q));
        return;
      }
    edges_.push_back({a, b});
  }
  int corner(unsigned q, int d, bool high) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    const int number = int(high) << d | int(q & 1) << e | int(q >> 1) << f;
    for (int c = 0; c < 3; ++c)  // a periodic side's node is that of the other side
      place_[number][c] = grid_.node(c, cell_[c]) + (number >> c & 1) * grid_.width(c, cell_[c]);
    return number;
  }
  int point(const CutFaces::Outline& around, int q, int d, bool high) {
    const int from = corner(around.from[q], d, high), to = corner(around.to[q], d, high);
    if (from == to) return from;
    const int bit = from ^ to, along = bit == 1 ? 0 : bit == 2 ? 1 : 2;
    const int number = 8 + 8 * along + (from & to);
    place_[number] = place_[from];
    const double share = around.point[q][along == (d + 1) % 3 ? 0 : 1];
    place_[number][along] = grid_.node(along, cell_[along]) + share * grid_.width(along, cell_[along]);
    return number;
  }

  const LocalGrid& grid_;
  const Int3 cell_;
  std::array<Vec3, kPoints> place_;
  std::vector<Edge> edges_;
};

}  // namespace

void outline_walls(const LocalGrid& grid, const CutFaces& faces, const FaceField<FineGrid>& alpha, OpenSpace& space) {
  for (const WallCell& wall : space.surface) {
    Polygons polygons(grid, wall.cell);
    const bool aligned = faces.aligned(wall.cell);
    for (int d = 0; d < 3; ++d)
      for (bool high : {false, true}) {
        Int3 face = wall.cell;
        face[d] += high;
        if (!(alpha[d](face[0], face[1], face[2]) > 0)) continue;
        const CutFaces::Outline around = faces.outline(d, face);
        if (aligned || around.n == 0) {
          polygons.add_whole(d, high);
          continue;
        }
        const int each = around.parted ? 3 : around.n;
        for (int first = 0; first < around.n; first += each) polygons.add(around, first, each, d, high);
      }
    space.outlines.push_back(polygons.open_line());
  }
}

}  // namespace twogrid
