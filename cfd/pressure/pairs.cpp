#include "cfd/pressure/pairs.h"

#include <algorithm>
#include <cmath>

namespace twogrid {

namespace {

/// Parent of each cell when neighbours of one brick are merged in pairs up to a distance.
std::vector<int> merge(const Line& line, double distance) {
  std::vector<int> parent(line.n());
  int next = 0;
  for (std::size_t c = 0; c + 1 < line.cut.size(); ++c)
    for (int i = line.cut[c]; i < line.cut[c + 1]; ++i, ++next) {
      parent[i] = next;
      if (i + 1 < line.cut[c + 1] && line.distance(i) <= distance) parent[++i] = next;
    }
  return parent;
}

/// Smallest distance of two neighbours of one brick; infinite if no brick has two cells.
double closest(const Line& line) {
  double d = INFINITY;
  for (std::size_t c = 0; c + 1 < line.cut.size(); ++c)
    for (int i = line.cut[c]; i + 1 < line.cut[c + 1]; ++i) d = std::min(d, line.distance(i));
  return d;
}

}  // namespace

Line coarse_line(const Line& fine, const std::vector<int>& parent) {
  Line coarse;
  for (int i = 0; i < fine.n(); ++i)
    if (i == 0 || parent[i] != parent[i - 1]) coarse.node.push_back(fine.node[i]);
  coarse.node.push_back(fine.node.back());
  for (int c : fine.cut) coarse.cut.push_back(c == fine.n() ? coarse.n() : parent[c]);
  return coarse;
}

Parents choose_pairs(const Lines& lines, double stretch, double shrink) {
  double distance = INFINITY;
  for (const Line& line : lines) distance = std::min(distance, closest(line));
  if (!std::isfinite(distance)) return {};
  distance *= stretch;
  double longest = 0;
  for (const Line& line : lines) longest = std::max(longest, line.node.back() - line.node.front());
  for (;; distance *= 1.25) {
    Parents parents;
    double left = 1;
    for (int d = 0; d < 3; ++d) {
      parents[d] = merge(lines[d], distance);
      left *= (parents[d].back() + 1.0) / lines[d].n();
    }
    if (left <= shrink || distance > longest) return parents;
  }
}

}  // namespace twogrid
