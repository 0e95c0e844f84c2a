#include "liggghts_fixes/liggghts/even_borders.h"

#include <algorithm>

namespace twogrid {

std::vector<double> even_borders(const std::vector<long long>& count, const std::vector<double>& old, double least) {
  const int bins = int(count.size()), parts = int(old.size()) - 1;
  double all = 0;
  for (long long c : count) all += double(c);
  std::vector<double> border = old;
  double below = 0;
  int bin = 0;
  for (int i = 1; i < parts; ++i) {
    const double wanted = all * i / parts;
    while (bin < bins - 1 && below + double(count[bin]) < wanted) below += double(count[bin++]);
    const double inside = count[bin] > 0 ? (wanted - below) / double(count[bin]) : 0.0;
    border[i] = std::clamp((bin + inside) / bins, old[i - 1], old[i + 1]);
  }
  // From below, then from above: no part narrower than what is least.
  for (int i = 1; i < parts; ++i) border[i] = std::max(border[i], border[i - 1] + least);
  for (int i = parts - 1; i > 0; --i) border[i] = std::min(border[i], border[i + 1] - least);
  return border;
}

}  // namespace twogrid
