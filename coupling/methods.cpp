#include "coupling/methods.h"

namespace twogrid {
namespace {

constexpr Method kMethods[] = {
    {"smooth", Deposit::kTrilinear, Prolong::kConstant, Read::kTrilinear, false, nullptr,
     "two-grid; the default: quiet in gas and in liquids however short the step, least scatter of the drag"},
    {"sharp", Deposit::kExact, Prolong::kConstant, Read::kTrilinear, false, nullptr,
     "two-grid; the void fraction of a bed's last cells is not spread beyond its end: for thin beds"},
    {"paper", Deposit::kCentroid, Prolong::kConstant, Read::kCell, false, nullptr, "two-grid: Deb & Tafti 2013"},
    {"jets", Deposit::kExact, Prolong::kConstant, Read::kFineTrilinear, false, nullptr,
     "two-grid; particles feel jets finer than a particle cell"},
    {"kernel", Deposit::kExact, Prolong::kConstant, Read::kKernel, false, "full width (m)",
     "two-grid; particles feel the fine grid through a kernel"},
    {"single", Deposit::kCentroid, Prolong::kConstant, Read::kFine, true, nullptr,
     "one grid, particle-centroid method (PCM)"},
    {"exact", Deposit::kExact, Prolong::kConstant, Read::kFine, true, nullptr,
     "one grid, volume of sphere and cell in common: Farzaneh et al."},
    {"cube", Deposit::kCube, Prolong::kConstant, Read::kCube, true, "edge (m)", "one grid, porous cube: Link et al."},
};

}  // namespace

const Method* find_method(const std::string& name) {
  for (const Method& m : kMethods)
    if (name == m.name) return &m;
  return nullptr;
}

std::string method_names() {
  std::string names;
  for (const Method& m : kMethods) names += (names.empty() ? "" : " ") + std::string(m.name);
  return names;
}

void choose(const Method& m, double length, Settings& s) {
  s.method = m.name;
  s.deposit = m.deposit;
  s.prolong = m.prolong;
  s.read = m.read;
  s.one_grid = m.one_grid;
  if (m.read == Read::kKernel) s.kernel_width = length;
  if (m.read == Read::kCube) s.cube_edge = length;
}

}  // namespace twogrid
