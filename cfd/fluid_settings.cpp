#include "cfd/fluid_settings.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "cfd/boundary/patches.h"

namespace twogrid {

namespace {

template <class... T>
std::string text_of(const T&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  return text.str();
}

[[noreturn]] void refuse(const std::string& keyword, const std::string& found, const std::string& wanted) {
  throw std::invalid_argument(keyword + ": found " + found + ", wanted " + wanted);
}

const char* axis_name(int d) {
  return d == 0 ? "x" : d == 1 ? "y" : "z";
}

std::string name_of(int side, const BoundaryCondition& c) {
  return text_of("boundary ", kSideNames[side], c.name.empty() ? "" : " patch ", c.name);
}

void check_shape(int side, const BoundaryCondition& c, const FineGrid& grid) {
  const int d = direction(side);
  const Axis &e = grid.axis[d == 0 ? 1 : 0], &f = grid.axis[d == 2 ? 1 : 2];
  std::array<double, 4> v = c.shape.value;
  std::string found;
  if (c.shape.kind == PatchShape::Kind::kRectangle) {
    found = text_of("rect ", v[0], " ", v[1], " ", v[2], " ", v[3]);
  } else if (c.shape.kind == PatchShape::Kind::kCircle) {
    found = text_of("circle ", v[0], " ", v[1], " ", v[2]);
    v = {v[0] - v[2], v[0] + v[2], v[1] - v[2], v[1] + v[2]};
  } else {
    return;
  }
  const double slack_e = 1e-9 * e.length(), slack_f = 1e-9 * f.length();
  if (!(v[0] < v[1] && v[2] < v[3]) || v[0] < e.lo() - slack_e || v[1] > e.hi() + slack_e || v[2] < f.lo() - slack_f ||
      v[3] > f.hi() + slack_f)
    refuse(
        name_of(side, c), found,
        text_of("a shape on the side's face, which spans ", e.lo(), " to ", e.hi(), " and ", f.lo(), " to ", f.hi()));
}

}  // namespace

void FluidSettings::check(const FineGrid& grid) const {
  if (!(density > 0)) refuse("density", text_of(density), "a fluid density above 0 (kg/m3)");
  if (!(viscosity >= 0)) refuse("viscosity", text_of(viscosity), "0 Pa s or more");
  if (!(cfl > 0 && cfl <= 1)) refuse("cfl", text_of(cfl), "a Courant number above 0 and at most 1");
  if (cfl > largest_cfl(convection))
    refuse("cfl", text_of(cfl) + " with 'convection central'",
           text_of("at most ", largest_cfl(convection),
                   ", above which that grows without bound, or 'convection vanleer'"));
  if (!(dt >= 0)) refuse("dt", text_of(dt), "0 (automatic) or a time in s");
  if (!(pressure_rtol > 0 && pressure_rtol < 1)) refuse("tolerance", text_of(pressure_rtol), "between 0 and 1");

  for (int s = 0; s < 6; ++s) {
    const int d = direction(s);
    const std::string keyword = text_of("boundary ", kSideNames[s]), in = text_of(" in ", axis_name(d));
    if (grid.axis[d].periodic()) {
      if (!side[s].empty() && (side[s].size() > 1 || side[s][0].kind != BoundaryKind::kPeriodic))
        refuse(keyword, "a condition on a side that is periodic for the particles",
               "no condition there, or f instead of p" + in + " in LIGGGHTS' boundary command");
      continue;
    }
    if (side[s].empty()) refuse(keyword, "no condition", "one");
    for (const BoundaryCondition& c : side[s]) {
      const std::string name = name_of(s, c);
      if (c.kind == BoundaryKind::kPeriodic)
        refuse(name, "periodic" + in + ", where the fluid is not", "another condition there");
      if (grid.axis[d].n() == 1 && c.kind == BoundaryKind::kNoSlip)
        refuse(name, "noslip with fine 1" + in,
               "slip there (with 'gap friction on' for the walls' friction), or at least 2 fine cells");
      if (c.kind == BoundaryKind::kNoSlip && c.velocity[d] != 0)
        refuse(name + " noslip", text_of("a velocity normal to the wall (", axis_name(d), ")"),
               "a wall that moves in its own plane, or an inlet");
      check_shape(s, c, grid);
      if (c.kind == BoundaryKind::kInlet && c.profile.shape == InletProfile::Shape::kTable && c.profile.table.empty())
        refuse(name + " inlet profile table", "an empty one", "at least 1 line of coordinate and factor");
    }
  }
  for (int d = 0; d < 3; ++d) {
    const char* driver = flow_rate_set[d] ? "flow_rate" : "pressure_gradient";
    if ((flow_rate_set[d] || pressure_gradient[d] != 0) && !grid.axis[d].periodic())
      refuse(driver, text_of("it in ", axis_name(d), ", which is not periodic"),
             "a periodic direction, or an inlet and an outlet");
  }
}

void FluidSettings::check_flow(const FineGrid& grid) const {
  double in = 0, out = 0;
  bool outlet = false, variable = false;
  for (int s = 0; s < 6; ++s) {
    const int d = direction(s);
    if (grid.axis[d].periodic()) continue;
    const std::vector<PatchSize> size = patch_sizes(*this, s, grid);
    for (std::size_t c = 0; c < side[s].size(); ++c) {
      const BoundaryCondition& condition = side[s][c];
      if (size[c].open == 0 && !condition.name.empty())
        refuse(name_of(s, condition), "a shape that holds no fine face's centre",
               "one that covers at least one fine face of the side, or more cells along the side by 'fine'");
      if (condition.kind == BoundaryKind::kPressure && size[c].open > 0) outlet = true;
      if (condition.kind != BoundaryKind::kInlet) continue;
      variable = variable || bool(condition.velocity_now);
      const Vec3 u = condition.velocity_now ? condition.velocity_now() : condition.velocity;
      const double flux = (is_high(s) ? -u[d] : u[d]) * size[c].open;
      (flux > 0 ? in : out) += std::abs(flux);
    }
  }
  if (outlet) return;
  for (const Body& body : bodies)
    if (body.blow.on)
      refuse("solid " + body.name + " blow", "gas that comes into the domain, and no outlet",
             "a side or patch with 'pressure 0'");
  if (std::abs(in - out) > 1e-9 * std::max(in, out))
    refuse("boundary", text_of("inlets that bring ", in, " m3/s and take ", out, " m3/s, and no outlet"),
           "a side or patch with 'pressure 0', or inlets that balance");
  if (variable)
    refuse("boundary", "an inlet that follows a variable, and no outlet", "a side or patch with 'pressure 0'");
}

}  // namespace twogrid
