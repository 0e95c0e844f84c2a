#include "liggghts_fixes/script/grid_choice.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

#include "cfd/grid/grid.h"
#include "cfd/grid/pi.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

namespace {

constexpr double kTarget = 3, kMost = 4, kMostOfLargest = 1.5;  // particle cells: d; of their least size
constexpr double kLeastForBed =
    2;  // d: smaller ones scatter, however the volume is deposited (studies drag_gradient, terminal_velocity)
constexpr double kAspect = 4, kRound = 1e-9, kAnyWidth = 1e300;
constexpr double kPatchError = 0.02;  // the scene report warns above it
constexpr int kFinestMore = 8, kKept = 10, kLooked = 500;

const char* const kAxis = "xyz";

std::string of_d(const GridScene& s, double width) {
  return brief(width / s.d) + " d";
}

std::string count_text(double n) {
  return n < 1e9 ? std::to_string(std::llround(n)) : brief(n);
}

/// What a direction wants.
struct Demand {
  double length = 0;
  double target = 0, least = 0, common = 0, most = 0;  // particle cells (m): wanted, never below, not below, not above
  double width = kAnyWidth;                            // of fine cells at most (m)
  std::string why;                                     // what asks for that
  bool thin = false;
  bool bed = false;       // particle cells are small for a bed that ends
  double bed_least = 0;   // and then not below (m)
  int cells = 1;          // at least
  std::string cells_why;  // what asks for these
};

/// Numbers of cells of one direction.
struct Candidate {
  int blocks = 1, ratio = 1;
  double penalty = 0;
  int fine() const { return blocks * ratio; }
};

/// Faces that a patch between a and b takes of n equal cells, those whose centre lies inside.
struct Taken {
  double error, shift;  // of the width, of the middle (both over the width)
};
Taken taken(const Demand& demand, double lo, int n, double a, double b) {
  const double h = demand.length / n;
  const double first = std::max(0.0, std::floor((a - lo) / h - 0.5 + kRound) + 1);
  const double last = std::min(n - 1.0, std::ceil((b - lo) / h - 0.5 - kRound) - 1);
  if (last < first) return {1, 0.5};
  const double width = (last - first + 1) * h, middle = lo + 0.5 * (first + last + 1) * h;
  return {std::abs(width / (b - a) - 1), std::abs(middle - 0.5 * (a + b)) / (b - a)};
}

double error_penalty(double error) {
  return 10 * error + (error > kPatchError * (1 - 1e-6) ? 1 : 0);
}

/// Whether a patch spans its side in that direction.
bool spans(double lo, double hi, double a, double b) {
  return a <= lo + kRound * (hi - lo) && b >= hi - kRound * (hi - lo);
}

/// Calls f(opening, its lower edge, upper edge) for those that are smaller than the domain along d.
template <class F>
void for_each_opening(const GridScene& s, int d, F&& f) {
  for (const Opening& o : s.openings) {
    const int n = direction(o.side), e = n == 0 ? 1 : 0;
    if (n == d) continue;
    const int at = d == e ? 0 : 2;
    if (!spans(s.domain[2 * d], s.domain[2 * d + 1], o.extent[at], o.extent[at + 1]))
      f(o, o.extent[at], o.extent[at + 1]);
  }
}

/// The share of its area that the faces of a circle or region are more or less than drawn.
double area_error(const GridScene& s, const Opening& o, const Int3& fine) {
  const int n = direction(o.side), e = n == 0 ? 1 : 0, f = n == 2 ? 1 : 2;
  const double x = 0.5 * (o.extent[0] + o.extent[1]), y = 0.5 * (o.extent[2] + o.extent[3]);
  const double r = 0.5 * (o.extent[1] - o.extent[0]), r_y = 0.5 * (o.extent[3] - o.extent[2]);
  const bool circle = o.kind == PatchShape::Kind::kCircle;
  const double he = (s.domain[2 * e + 1] - s.domain[2 * e]) / fine[e];
  const double hf = (s.domain[2 * f + 1] - s.domain[2 * f]) / fine[f];
  const auto range = [](double a, double lo, double h, int cells) {
    return int(std::clamp(std::floor((a - lo) / h), 0.0, double(cells)));
  };
  long long faces = 0;
  for (int j = range(y - r_y, s.domain[2 * f], hf, fine[f]);
       j < std::min(fine[f], range(y + r_y, s.domain[2 * f], hf, fine[f]) + 1); ++j)
    for (int i = range(x - r, s.domain[2 * e], he, fine[e]);
         i < std::min(fine[e], range(x + r, s.domain[2 * e], he, fine[e]) + 1); ++i) {
      const double at_x = s.domain[2 * e] + (i + 0.5) * he, at_y = s.domain[2 * f] + (j + 0.5) * hf;
      const double a = at_x - x, b = at_y - y;
      faces += circle ? a * a + b * b < r * r : o.inside(at_x, at_y);
    }
  return std::abs(double(faces) * he * hf / (circle ? kPi * r * r : o.area) - 1);
}

std::array<Demand, 3> demands(const GridScene& s, const GivenGrids& given) {
  std::array<Demand, 3> all;
  double finest = kAnyWidth;
  for (int d = 0; d < 3; ++d) {
    Demand& w = all[d];
    const std::string in = std::string(" in ") + kAxis[d];
    w.length = s.domain[2 * d + 1] - s.domain[2 * d];
    w.least = s.least * s.d_max;
    w.target = std::max(kTarget * s.d, w.least);
    w.common = std::max(s.least_common * s.d, w.least);
    w.most = std::max(kMost * s.d, kMostOfLargest * w.least);
    if (d == s.along && s.bed > 0 && s.bed / s.bed_cells < w.most) {
      const double target = w.target;
      w.bed_least = std::max(w.least, kLeastForBed * s.d);
      w.most = std::max(s.bed / s.bed_cells * (1 - 1e-6), w.bed_least);
      w.target = std::min(w.target, w.most), w.common = std::max(w.bed_least, std::min(w.common, 0.8 * w.most));
      w.bed = w.target < target * (1 - kRound);
    }
    w.thin = w.length < 2 * w.target * (1 - kRound);
    const auto ask = [&](double width, const std::string& why) {
      if (width < w.width * (1 - kRound)) w.width = width, w.why = why;
    };
    for_each_opening(s, d, [&](const Opening& o, double a, double b) {
      const int across = o.asks ? kCellsAcrossOpening : kCellsAcrossWallPatch;
      ask((b - a) / across, std::to_string(across) + " across " + o.name + ", " + brief(b - a) + " m wide" + in);
    });
    for (const WidthAcross& across : s.widths)
      if (across.size[d] > 0)
        ask(across.size[d] / across.cells, std::to_string(across.cells) + " across " + across.name);
    if (s.kernel > 0 && !w.thin) ask(s.kernel / 2, "2 across the kernel that particles read by");
    if (s.flows[d]) w.cells = 2, w.cells_why = "the fluid flows along it";
    if (s.rubs[d] && w.thin) w.cells = 4, w.cells_why = "its sides have noslip";
    if (given.fine[d] == 0) finest = std::min(finest, w.width);
    if (given.fine[d] == 0 && !w.thin) finest = std::min(finest, w.target);
  }
  for (int d = 0; d < 3; ++d) {
    Demand& w = all[d];
    if (w.thin && w.cells == 1 && w.width == kAnyWidth) continue;
    if (kAspect * finest < w.width * (1 - kRound) && (w.thin || kAspect * finest < w.target))
      w.width = kAspect * finest, w.why = "no cell more than " + brief(kAspect) + " times as long as wide";
  }
  return all;
}

/// So many fine cells are asked for, as numbers that can't overflow; and with as many particle cells at least.
double asked_cells(const Demand& w) {
  return std::max(double(w.cells), w.width < kAnyWidth ? std::ceil(w.length / w.width * (1 - kRound)) : 1.0);
}
double least_cells(const Demand& w) {
  return w.thin ? asked_cells(w) : std::max(asked_cells(w), std::ceil(w.length / w.most * (1 - kRound)));
}

[[noreturn]] void refuse_number(const GridScene& s, const std::array<Demand, 3>& demands, double cells) {
  std::string found;
  for (int d = 0; d < 3; ++d)
    found += (d ? ", " : "") + count_text(std::ceil(least_cells(demands[d]))) + " in " + kAxis[d] +
             (demands[d].why.empty()
                  ? " (particle cells of " + brief(demands[d].target) + " m = " + of_d(s, demands[d].target) + ")"
                  : " (" + demands[d].why + ")");
  refuse("fine", "auto, and a scene that asks for " + count_text(cells) + " cells: " + found,
         "at most " + count_text(kMostChosenCells) +
             " without being told: give numbers, such as fewer cells over what is smallest, a fine grid that 'stretch' "
             "makes "
             "finest there, or a smaller 'domain'");
}

/// Smallest width of a particle cell.
double smallest_block(const Demand& w, const GivenGrids& given, int d, int fine, int ratio) {
  if (given.stretch[d] == 1) return w.length / fine * ratio;
  const std::vector<double> node = graded_nodes(0, w.length, fine, given.stretch[d], given.symmetric[d]);
  double least = w.length;
  for (int i = 0; i + ratio <= fine; i += ratio) least = std::min(least, node[i + ratio] - node[i]);
  return least;
}

double penalty(const GridScene& s, const GivenGrids& given, const Demand& w, int d, int blocks, int ratio) {
  const int fine = blocks * ratio;
  const bool stretched = given.stretch[d] != 1;
  const double D = smallest_block(w, given, d, fine, ratio), need = std::min(w.width, D);
  double p = (w.thin ? 0 : std::abs(std::log(D / w.target))) + 0.5 * std::max(0.0, std::log(need * fine / w.length));
  double off = 0;
  int openings = 0;
  for_each_opening(s, d, [&](const Opening& o, double a, double b) {
    ++openings;
    if (stretched) return;
    if (o.kind == PatchShape::Kind::kRectangle) {
      const Taken t = taken(w, s.domain[2 * d], fine, a, b);
      p += error_penalty(t.error) + 0.5 * t.shift;
    }
    const double at = (0.5 * (a + b) - s.domain[2 * d]) / D;
    if (o.asks && b - a < D) off += std::abs(at - std::floor(at) - 0.5);
  });
  return p + (openings ? 0.4 * off / openings : 0);
}

/// Whether particle cells of r fine ones, of n, are as ratio auto takes them. Of cells that grow the smallest one counts.
bool suits(const GridScene& s, const GivenGrids& given, const Demand& w, int d, int n, int r) {
  if (r == n) return w.length < 3 * w.target;
  const double D = smallest_block(w, given, d, n, r);
  return D >= std::max(w.least, s.d_max) * (1 - kRound) && D <= 2 * w.target * (1 + kRound);
}

/// The number nearest to n that has a divisor which suits, if there is one with particle cells as they are wanted; 0: none.
int near_number(const GridScene& s, const GivenGrids& given, const Demand& w, int d, int n) {
  for (const bool wanted : {true, false})
    for (int away = 1; away <= std::max(10, n / 2); ++away)
      for (int m : {n + away, n - away})
        for (int r = 1; m > 0 && r <= m; ++r) {
          if (m % r != 0 || !suits(s, given, w, d, m, r)) continue;
          const double D = smallest_block(w, given, d, m, r);
          if (!wanted || (D >= w.common * (1 - kRound) && D <= w.most * (1 + kRound))) return m;
        }
  return 0;
}

[[noreturn]] void refuse_ratio(const GridScene& s, const GivenGrids& given, const Demand& w, int d) {
  const int n = given.fine[d], near = near_number(s, given, w, d, n);
  const std::string in = std::string(" in ") + kAxis[d];
  const bool stretched = given.stretch[d] != 1;
  refuse("ratio",
         "auto for fine " + text(n) + in + ", which no number divides into particle cells of " +
             of_d(s, std::max(w.least, s.d_max)) + " to " + of_d(s, 2 * w.target) + " (" +
             (stretched ? "the smallest cell has " : "cells of ") + of_d(s, smallest_block(w, given, d, n, 1)) + ")",
         (near ? "fine " + text(near) + in + ", or another number that has a suitable divisor; or " : "") +
             (stretched ? "a number for ratio" + in + ", or a smaller 'stretch'"
                        : "auto for fine" + in + ", or a number for ratio there"));
}

std::vector<Candidate> candidates(const GridScene& s, const GivenGrids& given, const Demand& w, int d) {
  std::vector<Candidate> all;
  const auto add = [&](int blocks, int ratio) {
    all.push_back({blocks, ratio, penalty(s, given, w, d, blocks, ratio)});
  };
  const std::string in = std::string(" in ") + kAxis[d];
  if (given.fine[d] > 0) {
    const int n = given.fine[d];
    if (given.ratio[d] > 0) {
      add(n / given.ratio[d], given.ratio[d]);
      return all;
    }
    for (int r = 1; r <= n; ++r)
      if (n % r == 0 && suits(s, given, w, d, n, r)) add(n / r, r);
    if (all.empty()) refuse_ratio(s, given, w, d);
    return all;
  }
  const double least = asked_cells(w);
  const int fixed = s.one_grid ? 1 : given.ratio[d];
  int from = 1, to = 1;
  if (!w.thin) {
    from = std::max(1, int(std::ceil(w.length / w.most * (1 - kRound))));
    to = std::max(1, int(std::floor(w.length / w.common * (1 + kRound))));
    const int middle = int(
        std::min(std::round(w.length / w.target), w.least > 0 ? std::floor(w.length / w.least * (1 + kRound)) : 1e9));
    if (from > to) from = to = std::max(1, middle);
    from = std::max(from, std::min(middle, to) - kLooked), to = std::min(to, std::max(middle, from) + kLooked);
  }
  if (fixed == 0) {
    for (int blocks = from; blocks <= to; ++blocks) {
      const int r = std::max(1, int(std::ceil(least / blocks * (1 - kRound))));
      for (int more = 0; more <= std::min(r, kFinestMore); ++more) add(blocks, r + more);
    }
    return all;
  }
  // Of a ratio that is given, finer cells make smaller particle cells.
  const int need = std::max(from, int(std::ceil(least / fixed * (1 - kRound))));
  const double most = w.least > 0 ? std::max(1.0, std::floor(w.length / w.least * (1 + kRound))) : 2.0 * need;
  if (need > most) {
    const std::string asks = w.width < kAnyWidth && least > w.cells ? w.why : w.cells_why;
    const std::string found = asks + ": cells of " + brief(w.length / least) + " m" + in + ", " + text(fixed) +
                              " of which have " + of_d(s, w.length / least * fixed);
    if (s.one_grid)
      refuse("fine", "auto with method " + s.method + ", which sees the particles on the fine cells, and " + found,
             "numbers, or one of the two-grid methods");
    refuse("ratio", text(fixed) + in + " with fine auto, and " + found,
           "at least " + text(std::ceil(least / most * (1 - kRound))) + " there, or auto");
  }
  for (int blocks = need; blocks <= std::min(std::max(double(to), 2.0 * need), most); ++blocks) add(blocks, fixed);
  return all;
}

/// What of its drag the bed lacks on such cells.
double lacking(const GridScene& s, const Demand& w, const Candidate& c) {
  return s.bed_missing * s.bed_cells * w.length / c.blocks / s.bed;
}

std::string percent(double share) {
  return brief(100 * share) + " %";
}

std::string reason(const GridScene& s, const GivenGrids& given, const Demand& w, int d, const Candidate& c) {
  const double h = w.length / c.fine(), D = w.length / c.blocks;
  const bool stretched = given.stretch[d] != 1;
  std::string t = "grid " + std::string(1, kAxis[d]) + ": " + std::to_string(c.fine()) +
                  (c.fine() > 1 ? " fine cells of " : " fine cell of ") + brief(h) + " m" +
                  (stretched ? " on average" : "") + (given.fine[d] ? " (given)" : "");
  if (given.fine[d] == 0) {
    const bool by_width = w.width < kAnyWidth && h <= w.width * (1 + 1e-6) &&
                          std::ceil(w.length / w.width * (1 - kRound)) > (w.thin ? w.cells : c.blocks);
    if (by_width)
      t += ": " + w.why;
    else if (w.thin && c.fine() > 1)
      t += ": " + w.cells_why;
    else if (w.thin)
      t += ": " + of_d(s, w.length) + ", less than two particle cells";
    else if (c.ratio == 1)
      t += ": as particle cells, nothing asks for finer ones";
    else
      t += ": as the ratio asks";
  }
  const bool whole = c.ratio == c.fine();
  const double smallest = stretched && !whole ? smallest_block(w, given, d, c.fine(), c.ratio) : D;
  t += "; " + std::to_string(c.blocks) + " particle cell" + (c.blocks > 1 ? "s" : "") + " of " +
       std::to_string(c.ratio) + (given.ratio[d] ? " (given), " : ", ") + of_d(s, smallest) +
       (stretched && !whole ? " the smallest" : "");
  if (!w.bed || given.fine[d] * given.ratio[d] != 0) return t;
  const double lacks = lacking(s, w, c);
  t += " (small for a bed of " + brief(s.bed) + " m, which lacks " +
       (lacks <= s.bed_missing ? "less than " + percent(s.bed_missing)
        : lacks > 0.3          ? "a third or more"
                               : "about " + percent(lacks)) +
       " of its drag where it ends" + (lacks > s.bed_missing ? "; not below " + of_d(s, w.bed_least) + ")" : ")");
  return t;
}

}  // namespace

GridChoice choose_grids(const GridScene& s, const GivenGrids& given) {
  if (!(s.d > 0))
    refuse("fine", "auto, or ratio auto, and no particles nor templates of them, whose size the particle cells go by",
           "particles, or a fix particletemplate/sphere, before the first run with the fluid; or numbers of cells");
  const std::array<Demand, 3> w = demands(s, given);
  double cells = 1;
  for (int d = 0; d < 3; ++d) cells *= given.fine[d] ? given.fine[d] : least_cells(w[d]);
  const bool chosen = given.fine[0] * given.fine[1] * given.fine[2] == 0;
  if (chosen && cells > kMostChosenCells) refuse_number(s, w, cells);

  std::array<std::vector<Candidate>, 3> all;
  for (int d = 0; d < 3; ++d) {
    all[d] = candidates(s, given, w[d], d);
    std::stable_sort(all[d].begin(), all[d].end(),
                     [](const Candidate& a, const Candidate& b) { return a.penalty < b.penalty - 1e-12; });
    all[d].resize(std::min(all[d].size(), std::size_t(kKept)));
  }
  std::map<std::array<std::ptrdiff_t, 3>, double> errors;  // by the opening's number, and the fine cells along its side
  const auto known_error = [&](const Opening& o, const Int3& fine) {
    const int n = direction(o.side);
    const auto [at, fresh] =
        errors.try_emplace({&o - s.openings.data(), fine[n == 0 ? 1 : 0], fine[n == 2 ? 1 : 2]}, 0.0);
    if (fresh) at->second = area_error(s, o, fine);
    return at->second;
  };
  std::array<Candidate, 3> best;
  double least = kAnyWidth;
  for (const Candidate& x : all[0])
    for (const Candidate& y : all[1])
      for (const Candidate& z : all[2]) {
        const Int3 fine{x.fine(), y.fine(), z.fine()};
        double p = x.penalty + y.penalty + z.penalty, wide = 0, narrow = kAnyWidth;
        for (const Opening& o : s.openings)
          if (o.kind == PatchShape::Kind::kCircle || (o.kind == PatchShape::Kind::kRegion && o.inside))
            p += error_penalty(known_error(o, fine));
        for (int d = 0; d < 3; ++d)
          if (fine[d] > 1)
            wide = std::max(wide, w[d].length / fine[d]), narrow = std::min(narrow, w[d].length / fine[d]);
        if (wide > 0) p += std::max(0.0, std::log(wide / narrow / kAspect));
        if (p < least - 1e-12) least = p, best = {x, y, z};
      }
  GridChoice choice;
  choice.reasons.push_back("grids: chosen (auto) for d = " + brief(s.d) + " m" + s.d_text);
  cells = 1;
  for (int d = 0; d < 3; ++d) {
    choice.fine[d] = best[d].fine(), choice.ratio[d] = best[d].ratio, cells *= best[d].fine();
    choice.reasons.push_back(reason(s, given, w[d], d, best[d]));
    if (w[d].bed && given.fine[d] * given.ratio[d] == 0) choice.end_told = lacking(s, w[d], best[d]) > s.bed_missing;
  }
  if (chosen && cells > kMostChosenCells) refuse_number(s, w, cells);
  return choice;
}

}  // namespace twogrid
