#include "fluid_settings.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace twogrid {

namespace {

template <class... T>
[[noreturn]] void refuse(const T&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  throw std::invalid_argument(text.str());
}

const char* axis_name(int d) {
  return d == 0 ? "x" : d == 1 ? "y" : "z";
}

}  // namespace

void FluidSettings::check(const FineGrid& grid) const {
  if (!(density > 0)) refuse("density is ", density, ", wanted: above 0 kg/m3; change 'density'");
  if (!(viscosity >= 0)) refuse("viscosity is ", viscosity, ", wanted: 0 Pa s or more; change 'viscosity'");
  if (!(cfl > 0 && cfl <= 1)) refuse("cfl is ", cfl, ", wanted: above 0 and at most 1; change 'cfl'");
  if (!(dt >= 0)) refuse("dt is ", dt, ", wanted: 0 (automatic) or a time in s; change 'dt'");
  if (!(pressure_rtol > 0 && pressure_rtol < 1))
    refuse("tolerance is ", pressure_rtol, ", wanted: between 0 and 1; change 'tolerance'");

  double in = 0;
  bool inlet = false, outlet = false, variable = false;
  for (int s = 0; s < 6; ++s) {
    const int d = direction(s);
    const Axis& axis = grid.axis[d];
    const int e = d == 0 ? 1 : 0, f = d == 2 ? 1 : 2;
    if (axis.periodic()) {
      if (!side[s].empty() && side[s][0].kind != BoundaryKind::kPeriodic)
        refuse("boundary ", kSideNames[s], " is set, but the box is periodic in ", axis_name(d),
               "; wanted: no condition there; take out 'boundary ", kSideNames[s], "' or make the box's boundary f");
      continue;
    }
    if (side[s].empty()) refuse("boundary ", kSideNames[s], " has no condition; add 'boundary ", kSideNames[s], "'");
    for (const BoundaryCondition& c : side[s]) {
      const bool whole = c.shape.kind == PatchShape::Kind::kWhole;
      if (c.kind == BoundaryKind::kPeriodic)
        refuse("boundary ", kSideNames[s], " is periodic, but the box is not periodic in ", axis_name(d),
               "; wanted: the box's 'boundary' p in that direction");
      if (c.kind == BoundaryKind::kNoSlip && axis.n() == 1)
        refuse("boundary ", kSideNames[s], " is noslip, but the fluid is 1 cell deep in ", axis_name(d),
               " ('fine'); wanted: slip (with 'gap friction on' for the drag of the walls), or at least 2 cells");
      if (c.kind == BoundaryKind::kNoSlip && c.velocity[d] != 0)
        refuse("boundary ", kSideNames[s], " noslip moves with ", c.velocity[d], " m/s normal to itself, wanted: 0");
      if (c.shape.kind == PatchShape::Kind::kRectangle) {
        const auto& v = c.shape.value;
        const double tol_e = 1e-9 * grid.axis[e].length(), tol_f = 1e-9 * grid.axis[f].length();
        if (!(v[0] < v[1] && v[2] < v[3]) || v[0] < grid.axis[e].lo() - tol_e || v[1] > grid.axis[e].hi() + tol_e ||
            v[2] < grid.axis[f].lo() - tol_f || v[3] > grid.axis[f].hi() + tol_f)
          refuse("patch ", c.name, " is rect ", v[0], " ", v[1], " ", v[2], " ", v[3], ", wanted: inside ",
                 kSideNames[s], ", that is ", axis_name(e), " from ", grid.axis[e].lo(), " to ", grid.axis[e].hi(),
                 ", ", axis_name(f), " from ", grid.axis[f].lo(), " to ", grid.axis[f].hi(), "; change 'boundary ",
                 kSideNames[s], " patch ", c.name, "'");
      }
      if (c.shape.kind == PatchShape::Kind::kCircle) {
        const auto& v = c.shape.value;
        if (!(v[2] > 0) || v[0] - v[2] < grid.axis[e].lo() - 1e-9 || v[0] + v[2] > grid.axis[e].hi() + 1e-9 ||
            v[1] - v[2] < grid.axis[f].lo() - 1e-9 || v[1] + v[2] > grid.axis[f].hi() + 1e-9)
          refuse("patch ", c.name, " is circle ", v[0], " ", v[1], " ", v[2],
                 ", wanted: a radius above 0 and all of it on ", kSideNames[s], "; change 'boundary ", kSideNames[s],
                 " patch ", c.name, "'");
      }
      if (c.kind == BoundaryKind::kInlet) {
        inlet = true;
        variable = variable || bool(c.velocity_now);
        if (whole)
          in += (is_high(s) ? -1 : 1) * c.velocity[d];
        else
          in += std::abs(c.velocity[d]);
        if (c.profile.shape == InletProfile::Shape::kTable && c.profile.table.empty())
          refuse("the profile table of boundary ", kSideNames[s],
                 " is empty, wanted: at least 1 line of coordinate and factor");
      }
      outlet = outlet || c.kind == BoundaryKind::kPressure;
    }
  }
  if (inlet && !outlet && (in != 0 || variable))
    refuse("fluid flows in through an inlet and no side lets it out; wanted: a 'boundary SIDE pressure P'");
  for (int d = 0; d < 3; ++d) {
    if ((flow_rate_set[d] || pressure_gradient[d] != 0) && !grid.axis[d].periodic())
      refuse(flow_rate_set[d] ? "flow_rate" : "pressure_gradient", " is given in ", axis_name(d),
             ", which is not periodic; wanted: a periodic direction, or an inlet and an outlet");
  }
}

}  // namespace twogrid
