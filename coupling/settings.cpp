#include "coupling/settings.h"

#include <cstdio>
#include <stdexcept>

#include "coupling/forces/drag.h"

namespace twogrid {

void check(const Settings& s) {
  auto refuse = [](const std::string& sentence) { throw std::invalid_argument(sentence); };
  auto number = [](double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", x);
    return std::string(text);
  };
  if (!find_drag_law(s.drag))
    refuse("drag: there is no law called '" + s.drag + "', wanted one of: " + drag_law_names());
  if (!(s.eps_min > 0 && s.eps_min < 1)) refuse("eps_min must lie between 0 and 1, found " + number(s.eps_min));
  if (s.read == Read::kKernel && !(s.kernel_width > 0))
    refuse("read kernel needs a width above 0 (m), found " + number(s.kernel_width));
  if ((s.read == Read::kCube || s.deposit == Deposit::kCube) && !(s.cube_edge > 0))
    refuse("cube needs an edge above 0 (m), found " + number(s.cube_edge));
}

double read_width(const Settings& s) {
  return s.read == Read::kKernel ? s.kernel_width : s.read == Read::kCube ? s.cube_edge : 0.0;
}

}  // namespace twogrid
