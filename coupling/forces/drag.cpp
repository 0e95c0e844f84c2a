#include "coupling/forces/drag.h"

#include <algorithm>
#include <cmath>

#include "cfd/grid/pi.h"
#include "cfd/parallel/vectorised.h"

// The C library has these eight, four and two at a time as well; said here, the compiler uses them in loops.
#if defined(__x86_64__) && !defined(__clang__) && defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 35)
extern "C" {
__attribute__((simd("notinbranch"))) double atan(double) noexcept;
__attribute__((simd("notinbranch"))) double exp(double) noexcept;
__attribute__((simd("notinbranch"))) double log(double) noexcept;
__attribute__((simd("notinbranch"))) double log10(double) noexcept;
}
#endif

namespace twogrid {
namespace {

// eps_s; never below zero, because eps may exceed 1 by a rounding and some laws take roots of eps_s.
double solid(double eps) {
  return std::max(0.0, 1 - eps);
}

// a^b for a >= 0; 0^b is 1e-60^b. Half the work of pow(), which carries the logarithm in more than a double: here the
// relative error is some 2e-16 (1 + |b ln a|), at most 3e-15 in the range of the laws. (0 itself would be taken out of
// a group and done alone.)
double power(double a, double b) {
  return std::exp(b * std::log(std::max(a, 1e-60)));
}

// C_D Re / 24 of a lone sphere: the drag over its Stokes value.
//   C_D = 24/Re (1 + 0.15 Re^0.687) for Re < 1000, else 0.44                    (Schiller & Naumann 1935; Newton)
// The two branches miss each other by 0.4 % at Re = 1000, upwards.
double lone_sphere(double Re) {
  const double slow = 1 + 0.15 * power(Re, 0.687), fast = 0.44 / 24 * Re;
  return Re < 1000 ? slow : fast;
}

// Dalla Valle (1948): C_D = (0.63 + 4.8 Re^-1/2)^2, hence C_D Re = (0.63 Re^1/2 + 4.8)^2. Its limit at Re = 0 is 0.96
// of Stokes' drag; that is the correlation's own.
double dalla_valle(double Re) {
  const double s = 0.63 * std::sqrt(Re) + 4.8;
  return s * s / 24;
}

// Stokes (1851): force = 3 pi mu d |u - v| on a lone sphere, whatever the void fraction. The source has no mean grad p,
// so the force is drag. F = 1/eps because F is per superficial slip.
double stokes(double eps, double, double) {
  return 1 / eps;
}

// Schiller & Naumann (1935): force = 3 pi mu d |u - v| (1 + 0.15 Re_i^0.687) on a lone sphere, whatever the void
// fraction, with Newton's 0.44 from Re_i = 1000 on. Drag alone, as for Stokes. The source's Re is the lone sphere's,
// rho_f |u - v| d / mu = Re/eps.
double schiller_naumann(double eps, double Re, double) {
  return lone_sphere(Re / eps) / eps;
}

// Ergun (1952): pressure drop of a packed bed at superficial velocity U = eps |u - v|,
//   dp/L = 150 mu eps_s^2 U / (d^2 eps^3) + 1.75 rho_f eps_s U^2 / (d eps^3).
// A pressure drop is the total force per volume; drag is eps times it, beta = eps^2 (dp/L) / U:
//   beta = 150 eps_s^2 mu / (eps d^2) + 1.75 eps_s rho_f |u - v| / d,   F = (150 eps_s + 1.75 Re) / (18 eps^2)
double ergun(double eps, double Re, double) {
  return (150 * solid(eps) + 1.75 * Re) / (18 * eps * eps);
}

// Wen & Yu (1966), with the exponent 2.65 that is in general use (their own eps^-4.7 for the total force is rounded to
// eps^-4.65, so drag goes with eps^-3.65):
//   beta = 3/4 C_D eps_s eps rho_f |u - v| / d * eps^-2.65,   F = C_D Re/24 * eps^-3.65
// Re superficial, by diameter, as ours. beta is that of formulation A (Gidaspow 1994, model A), so F holds drag alone.
double wen_yu(double eps, double Re, double) {
  return lone_sphere(Re) * power(eps, -3.65);
}

// Huilin & Gidaspow (2003): the two joined by
//   psi = atan(150 * 1.75 (0.2 - eps_s)) / pi + 1/2,   beta = (1 - psi) beta_Ergun + psi beta_WenYu.
// psi(0) = 0.994: a lone particle gets 0.6 % of Ergun's drag in place of Wen & Yu's.
double ergun_wen_yu(double eps, double Re, double y) {
  const double psi = std::atan(150 * 1.75 * (0.2 - (1 - eps))) / kPi + 0.5;
  return (1 - psi) * ergun(eps, Re, y) + psi * wen_yu(eps, Re, y);
}

// The same joint, stretched about its middle eps_s = 0.2 until it reaches 1 at eps_s = 0 and, by symmetry, 0 at
// eps_s = 0.4, where it stays for denser beds:
//   psi = max(0, 1/2 + 1/2 atan(150 * 1.75 (0.2 - eps_s)) / atan(150 * 1.75 * 0.2))
// so that a lone particle feels Wen & Yu and a packed bed Ergun, exactly. This rescaling is ours.
double ergun_wen_yu_rescaled(double eps, double Re, double y) {
  constexpr double kAtanEnd = 1.5517510108128802;  // atan(52.5)
  const double psi = std::max(0.0, 0.5 + 0.5 * std::atan(150 * 1.75 * (0.2 - (1 - eps))) / kAtanEnd);
  return (1 - psi) * ergun(eps, Re, y) + psi * wen_yu(eps, Re, y);
}

// Gidaspow (1994): Ergun for eps < 0.8, Wen & Yu from there on, with the jump this makes. Most codes call it Gidaspow's
// law; it goes by both names here. Gidaspow's later, smooth law is ergun_wen_yu above.
double ergun_wen_yu_jump(double eps, double Re, double y) {
  const double dense = ergun(eps, Re, y), dilute = wen_yu(eps, Re, y);
  return eps < 0.8 ? dense : dilute;
}

// Di Felice (1994): force = (pi d^2/4) 1/2 rho_f U^2 C_D eps^-chi, U = eps |u - v| superficial, Re by U and d,
//   C_D of Dalla Valle,   chi = 3.7 - 0.65 exp(-(1.5 - log10 Re)^2 / 2).
// The force balances eps V_p (rho_p - rho_f) g of a suspended particle: it is drag, without V_p grad p.
double di_felice(double eps, double Re, double) {
  double chi = 3.7;
  if (Re > 0) {
    const double a = 1.5 - std::log10(Re);
    chi -= 0.65 * std::exp(-0.5 * a * a);
  }
  return dalla_valle(Re) * power(eps, -chi);
}

// Koch & Hill (2001), from Hill, Koch & Ladd (2001), in the form F_HKL = F0(eps_s) + F3(eps_s) Re_a:
//   F0 = (1 + 3 (eps_s/2)^1/2 + 135/64 eps_s ln eps_s + 16.14 eps_s) / (1 + 0.681 eps_s - 8.48 eps_s^2 + 8.16 eps_s^3)
//        for eps_s < 0.4,  10 eps_s / eps^3 above (they differ by 1 % at 0.4)
//   F3 = 0.0673 + 0.212 eps_s + 0.0232 / eps^5
// Re_a is superficial but by RADIUS: Re_a = Re/2. F_HKL is the TOTAL force over 6 pi mu a U (10 eps_s/eps^3 is Carman's
// pressure drop), so F = eps F_HKL. Hill, Koch & Ladd's own fit has 17.14 in place of 16.14 and blends towards
// 10 eps_s/eps^3; the simple form is what CFD-DEM codes use. F3 Re_a belongs to moderate Re_a; as is usual it is kept
// down to Re_a = 0.
double koch_hill(double eps, double Re, double) {
  const double s = solid(eps);
  const double s_ln_s = s > 0 ? s * std::log(s) : 0;
  const double F0 = s < 0.4 ? (1 + 3 * std::sqrt(s / 2) + 135.0 / 64 * s_ln_s + 16.14 * s) /
                                  (1 + s * (0.681 + s * (-8.48 + s * 8.16)))
                            : 10 * s / (eps * eps * eps);
  const double F3 = 0.0673 + 0.212 * s + 0.0232 / power(eps, 5);
  return eps * (F0 + F3 * Re / 2);
}

// Beetstra, van der Hoef & Kuipers (2007), spheres of one diameter:
//   F = 10 eps_s/eps^2 + eps^2 (1 + 1.5 eps_s^1/2)
//     + 0.413 Re/(24 eps^2) (1/eps + 3 eps_s eps + 8.4 Re^-0.343) / (1 + 10^(3 eps_s) Re^-(1 + 4 eps_s)/2)
// Superficial Re by diameter. Their F is drag alone over 3 pi mu d U (they give the total force as drag/eps): as ours.
// The last term is written with k = (1 + 4 eps_s)/2, both sides of its fraction times Re^k, so that it is 0 at Re = 0.
double beetstra(double eps, double Re, double) {
  const double s = solid(eps);
  const double Re_k = power(Re, 0.5 + 2 * s);
  const double inertia = (Re * (1 / eps + 3 * s * eps) + 8.4 * power(Re, 0.657)) * Re_k / (Re_k + power(10.0, 3 * s));
  return 10 * s / (eps * eps) + eps * eps * (1 + 1.5 * std::sqrt(s)) + 0.413 / (24 * eps * eps) * inertia;
}

// The same for a mixture. The TOTAL force on a sphere of size y = d_i/<d>, times eps, is (van der Hoef, Beetstra &
// Kuipers 2005; Beetstra et al. 2007)
//   (eps y + eps_s y^2 + 0.064 eps y^3) F(eps, <Re>) * 3 pi mu d_i U,   <Re> by the Sauter mean diameter = Re/y.
// Its y^2 term is -V_p grad p: with -grad p = 3 pi mu U F sum n_k d_k^2 / (eps <d>) it is eps_s y^2 F / eps. What is
// left is the drag,
//   F_i = (y + 0.064 y^3) F(eps, <Re>)
// (the erratum of Beetstra et al. 2007 makes the same distinction). At y = 1 the factor is 1.064, not 1: the y^3 term
// was fitted to size ratios far from one. Its own small share in grad p is neglected here.
double beetstra_poly(double eps, double Re, double y) {
  return y * (1 + 0.064 * y * y) * beetstra(eps, Re / y, 1);
}

// Tenneti, Garg & Subramaniam (2011):
//   F_T = C_D Re/24 / eps^3 + 5.81 eps_s/eps^3 + 0.48 eps_s^1/3 / eps^4 + eps_s^3 Re (0.95 + 0.61 eps_s^3/eps^2)
// C_D of the lone sphere above; superficial Re by diameter. Their force holds the mean pressure gradient's share (at
// eps_s = 0.4, Re = 0: 18.1 against Carman's total 18.5 and drag 11.1), so F = eps F_T.
double tenneti(double eps, double Re, double) {
  const double s = solid(eps), s3 = s * s * s, eps2 = eps * eps;
  return (lone_sphere(Re) + 5.81 * s) / eps2 + 0.48 * std::cbrt(s) / (eps2 * eps) +
         eps * s3 * Re * (0.95 + 0.61 * s3 / eps2);
}

// Syamlal & O'Brien (1987), printed in Syamlal, Rogers & O'Brien (1993), eqs 11-16:
//   beta = 3/4 C_D eps_s eps rho_f |u - v| / (V_r^2 d),   C_D = (0.63 + 4.8 (V_r/Re_i)^1/2)^2
//   V_r  = 1/2 (A - 0.06 Re_i + ((0.06 Re_i)^2 + 0.12 Re_i (2 B - A) + A^2)^1/2)
//   A = eps^4.14,   B = 0.8 eps^1.28 for eps <= 0.85, eps^2.65 above
// V_r, terminal velocity in the suspension over that of a lone particle, is Garside & Al-Dibouni's; C_D Dalla Valle's
// at Re_i/V_r. Re_i = rho_f |u - v| d / mu = Re/eps is NOT superficial. beta multiplies (u - v) beside eps grad p, that
// is formulation A. F = C_D Re_i / (24 V_r^2).
double syamlal_obrien(double eps, double Re, double) {
  const double Re_i = Re / eps, r = 0.06 * Re_i;
  const double A = power(eps, 4.14);
  const double B = eps <= 0.85 ? 0.8 * power(eps, 1.28) : power(eps, 2.65);
  // 1/2 (A - r + root) loses digits when r is large: (root + (A - r)) (root - (A - r)) = 4 r B.
  const double root = std::sqrt(r * r + 2 * r * (2 * B - A) + A * A);
  const double Vr = A > r ? 0.5 * (A - r + root) : 2 * r * B / (root - (A - r));
  return dalla_valle(Re_i / Vr) / Vr;
}

/// In groups of one size, so that no particle is left to a loop of another kind, whose functions may differ in the last
/// digit. (Between two groups stands a barrier: else the compiler takes several at once, and those left over
/// otherwise.) Here eight numbers at once pay: logarithms and exponentials are most of the work.
template <double (*F)(double, double, double)>
TWOGRID_VECTORISED_WIDE void F_of(int n, const double* eps, const double* Re, const double* y, double* out) {
  for (int first = 0; first < n; first += kDragBatch) {
#pragma GCC ivdep
#pragma GCC unroll 1
    for (int q = first; q < first + kDragBatch; ++q) out[q] = F(eps[q], Re[q], y[q]);
    asm volatile("" ::: "memory");
  }
}

constexpr DragLaw kLaws[] = {
    {"ergun/wenyu", ergun_wen_yu, F_of<ergun_wen_yu>,
     "Ergun 1952 and Wen & Yu 1966, joined as by Huilin & Gidaspow 2003"},
    {"ergun/wenyu/rescaled", ergun_wen_yu_rescaled, F_of<ergun_wen_yu_rescaled>,
     "as ergun/wenyu, the joint rescaled to reach 1 at eps = 1, 0 at 0.6"},
    {"ergun/wenyu/jump", ergun_wen_yu_jump, F_of<ergun_wen_yu_jump>, "Ergun 1952 below eps = 0.8, Wen & Yu 1966 above"},
    {"wenyu", wen_yu, F_of<wen_yu>, "Wen & Yu 1966"},
    {"ergun", ergun, F_of<ergun>, "Ergun 1952"},
    {"difelice", di_felice, F_of<di_felice>, "Di Felice 1994"},
    {"gidaspow", ergun_wen_yu_jump, F_of<ergun_wen_yu_jump>, "Gidaspow 1994; the same as ergun/wenyu/jump"},
    {"kochhill", koch_hill, F_of<koch_hill>, "Koch & Hill 2001; Hill, Koch & Ladd 2001"},
    {"beetstra", beetstra, F_of<beetstra>, "Beetstra, van der Hoef & Kuipers 2007"},
    {"beetstra/poly", beetstra_poly, F_of<beetstra_poly>,
     "Beetstra, van der Hoef & Kuipers 2007 with erratum; van der Hoef et al. 2005", true},
    {"tenneti", tenneti, F_of<tenneti>, "Tenneti, Garg & Subramaniam 2011"},
    {"syamlal", syamlal_obrien, F_of<syamlal_obrien>,
     "Syamlal & O'Brien 1987 as in Syamlal, Rogers & O'Brien 1993; Garside & Al-Dibouni 1977; Dalla Valle 1948"},
    {"schiller/naumann", schiller_naumann, F_of<schiller_naumann>, "Schiller & Naumann 1935"},
    {"stokes", stokes, F_of<stokes>, "Stokes 1851"},
};

}  // namespace

const DragLaw* find_drag_law(const std::string& name) {
  for (const DragLaw& law : kLaws)
    if (name == law.name) return &law;
  return nullptr;
}

std::string drag_law_names() {
  std::string names;
  for (const DragLaw& law : kLaws) names += (names.empty() ? "" : " ") + std::string(law.name);
  return names;
}

std::string mixture_law_names() {
  std::string names;
  for (const DragLaw& law : kLaws)
    if (law.for_mixtures) names += (names.empty() ? "" : " ") + std::string(law.name);
  return names;
}

}  // namespace twogrid
