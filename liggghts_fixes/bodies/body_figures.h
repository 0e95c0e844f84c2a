// What f_ID shows of the bodies: forces of the fluid on them, and how many particles lie in their cells, as the last coupling
// left them. Kept in checkpoints.
#pragma once

#include <string>
#include <vector>

#include "cfd/bodies/body_forces.h"
#include "coupling/report.h"

namespace twogrid {

struct BodyFigures {
  static constexpr int kEach = 6;   ///< force (N), torque about the centre of its surface (N m)
  static constexpr int kOfAll = 2;  ///< Report::in_walls, behind_walls
  static int count(std::size_t bodies) { return bodies > 0 ? kEach * int(bodies) + kOfAll : 0; }
  std::vector<double> value;  ///< of each body, one after the other, then of all

  void take(const std::vector<BodyForce>& forces, const Report& report) {
    value.clear();
    for (const BodyForce& f : forces) {
      const Vec3 force = f.force();
      value.insert(value.end(), force.begin(), force.end());
      value.insert(value.end(), f.torque.begin(), f.torque.end());
    }
    if (forces.empty()) return;
    value.push_back(double(report.in_walls));
    value.push_back(double(report.behind_walls));
  }

  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    for (std::size_t i = 0; i < s.value.size(); ++i) f(("value_" + std::to_string(i)).c_str(), s.value[i]);
  }
};

}  // namespace twogrid
