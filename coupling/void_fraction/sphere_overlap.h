// Volume of a sphere cut by planes normal to the axes: closed formulas, no quadrature.
//
// Unit ball around the origin, r^2 = 1 - a^2 and so on. The part beyond one, two and three planes:
//   cap      x > a                    (pi/3) (1 - a)^2 (2 + a)
//   edge     x > a, y > b             by the divergence theorem with the field x/3: a third of
//   corner   x > a, y > b, z > c      (spherical area) - a (flat area at x = a) - b (...) - c (...)
// The spherical area follows from Gauss and Bonnet's theorem: 2 pi - sum of exterior angles - sum of the arcs' geodesic
// curvature. With z_ab = sqrt(1 - a^2 - b^2) the half length of the edge inside the ball, and so on,
//   exterior angle at the edge (a, b)   atan2(z_ab, -a b)
//   arc at x = a, corner                phi_a = atan2(z_ab, b) - atan2(c, y_ac);  curvature a phi_a
//   flat area at x = a, corner          (r_a^2 phi_a - b (z_ab - c) - c (y_ac - b)) / 2
// All angles come from the same three half lengths: the derivative of the volume with respect to each of them vanishes
// with it, so that the formulas stay accurate (to some 1e-16 of the ball) where planes touch the sphere.
#pragma once

namespace twogrid {

/// Volume of the unit ball beyond the plane x = a.
double ball_beyond(double a);
/// Volume of the unit ball with x > a and y > b.
double ball_beyond(double a, double b);
/// Volume of the unit ball with x > a, y > b and z > c.
double ball_beyond(double a, double b, double c);

}  // namespace twogrid
