// Manufactured solutions: exact fields given as formulas of numbers that carry their first and second derivatives, from
// which the momentum source follows without a derivation by hand.
#pragma once

#include <array>
#include <cmath>

#include "cfd/grid/box.h"

namespace twogrid {

/// A function of (x, y, z, t) at a point: value, gradient and second derivatives (second-order Taylor arithmetic).
struct Taylor {
  double v = 0;
  std::array<double, 4> g{};
  std::array<double, 10> h{};  // of (0,0) (0,1) (0,2) (0,3) (1,1) (1,2) (1,3) (2,2) (2,3) (3,3)

  Taylor(double value = 0) : v(value) {}
  static Taylor variable(double value, int which) {
    Taylor r(value);
    r.g[which] = 1;
    return r;
  }
  double second(int a, int b) const {
    const int low = a < b ? a : b, high = a < b ? b : a;
    return h[low * (7 - low) / 2 + high];
  }
  /// f(this), given f, f' and f'' at the value.
  Taylor chain(double f, double f1, double f2) const {
    Taylor r(f);
    int q = 0;
    for (int a = 0; a < 4; ++a) {
      r.g[a] = f1 * g[a];
      for (int b = a; b < 4; ++b, ++q) r.h[q] = f1 * h[q] + f2 * g[a] * g[b];
    }
    return r;
  }
};

inline Taylor operator+(Taylor a, const Taylor& b) {
  a.v += b.v;
  for (int i = 0; i < 4; ++i) a.g[i] += b.g[i];
  for (int i = 0; i < 10; ++i) a.h[i] += b.h[i];
  return a;
}
inline Taylor operator*(const Taylor& a, const Taylor& b) {
  Taylor r(a.v * b.v);
  int q = 0;
  for (int i = 0; i < 4; ++i) {
    r.g[i] = a.g[i] * b.v + a.v * b.g[i];
    for (int j = i; j < 4; ++j, ++q) r.h[q] = a.h[q] * b.v + a.v * b.h[q] + a.g[i] * b.g[j] + a.g[j] * b.g[i];
  }
  return r;
}
inline Taylor operator*(double a, Taylor b) {
  b.v *= a;
  for (double& g : b.g) g *= a;
  for (double& h : b.h) h *= a;
  return b;
}
inline Taylor operator+(Taylor a, double b) {
  a.v += b;
  return a;
}
inline Taylor operator+(double a, const Taylor& b) {
  return b + a;
}
inline Taylor operator-(const Taylor& a, double b) {
  return a + -b;
}
inline Taylor operator-(double a, const Taylor& b) {
  return -1 * b + a;
}
inline Taylor operator-(Taylor a, const Taylor& b) {
  a.v -= b.v;
  for (int i = 0; i < 4; ++i) a.g[i] -= b.g[i];
  for (int i = 0; i < 10; ++i) a.h[i] -= b.h[i];
  return a;
}
inline Taylor operator/(const Taylor& a, const Taylor& b) {
  return a * b.chain(1 / b.v, -1 / (b.v * b.v), 2 / (b.v * b.v * b.v));
}
inline Taylor sin(const Taylor& a) {
  const double s = std::sin(a.v), c = std::cos(a.v);
  return a.chain(s, c, -s);
}
inline Taylor cos(const Taylor& a) {
  const double s = std::sin(a.v), c = std::cos(a.v);
  return a.chain(c, -s, -c);
}

/// Exact fields at a point: void fraction, volume flux eps u and pressure.
struct ExactFields {
  Taylor eps;
  std::array<Taylor, 3> flux;
  Taylor p;
};

/// A solution gives its fields at the four variables x, y, z, t.
using Solution = ExactFields (*)(const std::array<Taylor, 4>&);

inline ExactFields at(Solution s, const Vec3& x, double t) {
  return s({Taylor::variable(x[0], 0), Taylor::variable(x[1], 1), Taylor::variable(x[2], 2), Taylor::variable(t, 3)});
}

/// d(eps)/dt + div(eps u), to be given as the mass source q.
inline double mass_residual(const ExactFields& e) {
  return e.eps.g[3] + e.flux[0].g[0] + e.flux[1].g[1] + e.flux[2].g[2];
}

/// rho [d(eps u)/dt + div(eps u u) - q u] + s dp/dx_i - div(eps tau), component i; s = eps (formulation A) or 1 (B).
inline double momentum_residual(const ExactFields& e, int i, double rho, double mu, bool formulation_a) {
  const double v = e.eps.v;
  const Taylor inverse = e.eps.chain(1 / v, -1 / (v * v), 2 / (v * v * v));
  const std::array<Taylor, 3> u{e.flux[0] * inverse, e.flux[1] * inverse, e.flux[2] * inverse};
  double sum = rho * e.flux[i].g[3] - rho * mass_residual(e) * u[i].v + (formulation_a ? e.eps.v : 1.0) * e.p.g[i];
  double divergence = 0;
  for (int j = 0; j < 3; ++j) divergence += u[j].g[j];
  for (int j = 0; j < 3; ++j) {
    sum += rho * (e.flux[j].g[j] * u[i].v + e.flux[j].v * u[i].g[j]);
    sum -= mu * (e.eps.g[j] * (u[i].g[j] + u[j].g[i]) + e.eps.v * (u[i].second(j, j) + u[j].second(i, j)));
    sum += mu * 2.0 / 3.0 * e.eps.v * u[j].second(i, j);
  }
  sum += mu * 2.0 / 3.0 * e.eps.g[i] * divergence;
  return sum;
}

}  // namespace twogrid
