#include "coupling/void_fraction/sphere_overlap.h"

#include <algorithm>
#include <cmath>

#include "cfd/grid/pi.h"

namespace twogrid {

double ball_beyond(double a) {
  if (a >= 1) return 0;
  if (a <= -1) return 4 * kPi / 3;
  return kPi / 3 * (1 - a) * (1 - a) * (2 + a);
}

double ball_beyond(double a, double b) {
  if (a >= 1 || b >= 1) return 0;
  if (a <= -1) return ball_beyond(b);
  if (b <= -1) return ball_beyond(a);
  const double z2 = 1 - a * a - b * b;
  if (z2 <= 0) {
    // The edge misses the ball: the region is a difference of whole caps.
    if (a < 0) return ball_beyond(b) - (b < 0 ? ball_beyond(-a) : 0.0);
    return b < 0 ? ball_beyond(a) : 0.0;
  }
  const double z = std::sqrt(z2);
  const double at_a = 2 * std::atan2(z, b), at_b = 2 * std::atan2(z, a);  // arcs
  const double area = 2 * kPi - 2 * std::atan2(z, -a * b) - a * at_a - b * at_b;
  const double flat_a = 0.5 * (1 - a * a) * at_a - b * z;
  const double flat_b = 0.5 * (1 - b * b) * at_b - a * z;
  return std::max(0.0, (area - a * flat_a - b * flat_b) / 3);
}

double ball_beyond(double a, double b, double c) {
  if (a >= 1 || b >= 1 || c >= 1) return 0;
  if (a <= -1) return ball_beyond(b, c);
  if (b <= -1) return ball_beyond(a, c);
  if (c <= -1) return ball_beyond(a, b);
  if (a * a + b * b + c * c >= 1) {
    // The corner lies outside the ball: turn the planes round, one after the other, until all are on the far side.
    if (a < 0) return ball_beyond(b, c) - ball_beyond(-a, b, c);
    if (b < 0) return ball_beyond(a, c) - ball_beyond(a, -b, c);
    if (c < 0) return ball_beyond(a, b) - ball_beyond(a, b, -c);
    return 0;
  }
  const double z = std::sqrt(std::max(0.0, 1 - a * a - b * b));
  const double y = std::sqrt(std::max(0.0, 1 - a * a - c * c));
  const double x = std::sqrt(std::max(0.0, 1 - b * b - c * c));
  const double at_a = std::atan2(z, b) - std::atan2(c, y);
  const double at_b = std::atan2(z, a) - std::atan2(c, x);
  const double at_c = std::atan2(y, a) - std::atan2(b, x);
  const double area =
      2 * kPi - std::atan2(z, -a * b) - std::atan2(y, -a * c) - std::atan2(x, -b * c) - a * at_a - b * at_b - c * at_c;
  const double flat_a = 0.5 * ((1 - a * a) * at_a - b * (z - c) - c * (y - b));
  const double flat_b = 0.5 * ((1 - b * b) * at_b - a * (z - c) - c * (x - a));
  const double flat_c = 0.5 * ((1 - c * c) * at_c - a * (y - b) - b * (x - a));
  return std::max(0.0, (area - a * flat_a - b * flat_b - c * flat_c) / 3);
}

}  // namespace twogrid
