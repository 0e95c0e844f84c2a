// Drag laws against figures that don't come from this code.
//
// Where the figures come from:
//  - published numbers: a pressure drop by Ergun's equation from another library's documentation; the standard drag
//    curve; the indices of Richardson & Zaki and of Garside & Al-Dibouni; the agreement of three correlations of
//    simulated random arrays. They pin down conventions (superficial or not, radius or diameter, total force or drag).
//  - no printed table of F(eps, Re) could be found for Di Felice, Koch & Hill, Beetstra, Tenneti or Syamlal & O'Brien.
//    The table below is therefore an independent evaluation: each publication's formula in its own symbols (a pressure
//    drop, a C_D, a total force over 6 pi mu a U, a beta) for d = 2 mm, mu = 1.8e-5 Pa s, rho_f = 1.2 kg/m3, as a force
//    in newtons, in 30-digit arithmetic, then divided by 3 pi mu d U. It shares no algebra with the code under test,
//    but a constant misread in both would pass.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "coupling/forces/drag.h"

namespace twogrid {
namespace {

constexpr double kPi = 3.14159265358979323846;

const std::vector<std::string> kNames = {"ergun/wenyu",
                                         "ergun/wenyu/rescaled",
                                         "ergun/wenyu/jump",
                                         "wenyu",
                                         "ergun",
                                         "difelice",
                                         "gidaspow",
                                         "kochhill",
                                         "beetstra",
                                         "beetstra/poly",
                                         "tenneti",
                                         "syamlal",
                                         "schiller/naumann",
                                         "stokes"};

double F(const std::string& name, double eps, double Re, double y = 1) {
  const DragLaw* law = find_drag_law(name);
  EXPECT_NE(law, nullptr) << name;
  return law ? law->F(eps, Re, y) : NAN;
}

struct Row {
  const char* law;
  double eps, Re, y, F;
};

// Re = 0 stands for the limit (evaluated at U = 1e-24 m/s).
const Row kTable[] = {
    {"ergun/wenyu", 0.4, 0, 1, 31.2411946},
    {"ergun/wenyu", 0.45, 10, 1, 27.4502943},
    {"ergun/wenyu", 0.6, 100, 1, 36.2235267},
    {"ergun/wenyu", 0.75, 50, 1, 12.2685035},
    {"ergun/wenyu", 0.9, 1, 1, 1.6827721},
    {"ergun/wenyu", 0.95, 300, 1, 10.4904619},
    {"ergun/wenyu", 0.5, 2000, 1, 793.093852},
    {"ergun/wenyu", 1, 40, 1, 2.89711419},
    {"ergun/wenyu/rescaled", 0.4, 0, 1, 31.25},
    {"ergun/wenyu/rescaled", 0.45, 10, 1, 27.4348422},
    {"ergun/wenyu/rescaled", 0.6, 100, 1, 36.2654321},
    {"ergun/wenyu/rescaled", 0.75, 50, 1, 12.2871223},
    {"ergun/wenyu/rescaled", 0.9, 1, 1, 1.68600852},
    {"ergun/wenyu/rescaled", 0.95, 300, 1, 10.354796},
    {"ergun/wenyu/rescaled", 0.5, 2000, 1, 794.444444},
    {"ergun/wenyu/rescaled", 1, 40, 1, 2.89106507},
    {"wenyu", 0.4, 0, 1, 28.3452983},
    {"wenyu", 0.45, 10, 1, 31.895008},
    {"wenyu", 0.6, 100, 1, 29.3529918},
    {"wenyu", 0.75, 50, 1, 9.15732163},
    {"wenyu", 0.9, 1, 1, 1.68932295},
    {"wenyu", 0.95, 300, 1, 10.3088483},
    {"wenyu", 0.5, 2000, 1, 460.289337},
    {"wenyu", 1, 40, 1, 2.89106507},
    {"ergun", 0.4, 0, 1, 31.25},
    {"ergun", 0.45, 10, 1, 27.4348422},
    {"ergun", 0.6, 100, 1, 36.2654321},
    {"ergun", 0.75, 50, 1, 12.345679},
    {"ergun", 0.9, 1, 1, 1.14883402},
    {"ergun", 0.95, 300, 1, 32.7793167},
    {"ergun", 0.5, 2000, 1, 794.444444},
    {"ergun", 1, 40, 1, 3.88888889},
    {"difelice", 0.4, 0, 1, 28.4871672},
    {"difelice", 0.45, 10, 1, 23.3347193},
    {"difelice", 0.6, 100, 1, 25.3523106},
    {"difelice", 0.75, 50, 1, 8.61341024},
    {"difelice", 0.9, 1, 1, 1.77433328},
    {"difelice", 0.95, 300, 1, 12.1811052},
    {"difelice", 0.5, 2000, 1, 538.646747},
    {"difelice", 1, 40, 1, 3.21528794},
    {"kochhill", 0.4, 0, 1, 37.5},
    {"kochhill", 0.45, 10, 1, 30.4031059},
    {"kochhill", 0.6, 100, 1, 24.6247284},
    {"kochhill", 0.75, 50, 1, 9.32929088},
    {"kochhill", 0.9, 1, 1, 2.59841154},
    {"kochhill", 0.95, 300, 1, 17.2148507},
    {"kochhill", 0.5, 2000, 1, 477.85},
    {"kochhill", 1, 40, 1, 2.81},
    {"beetstra", 0.4, 0, 1, 37.8459032},
    {"beetstra", 0.45, 10, 1, 30.3025456},
    {"beetstra", 0.6, 100, 1, 30.7415526},
    {"beetstra", 0.75, 50, 1, 11.0543444},
    {"beetstra", 0.9, 1, 1, 2.4981603},
    {"beetstra", 0.95, 300, 1, 14.7876499},
    {"beetstra", 0.5, 2000, 1, 484.216048},
    {"beetstra", 1, 40, 1, 3.00306281},
    {"tenneti", 0.4, 0, 1, 34.363245},
    {"tenneti", 0.45, 10, 1, 29.7237808},
    {"tenneti", 0.6, 100, 1, 24.7931061},
    {"tenneti", 0.75, 50, 1, 9.56219652},
    {"tenneti", 0.9, 1, 1, 2.44351173},
    {"tenneti", 0.95, 300, 1, 10.034251},
    {"tenneti", 0.5, 2000, 1, 318.209477},
    {"tenneti", 1, 40, 1, 2.89106507},
    {"syamlal", 0.4, 0, 1, 42.632703},
    {"syamlal", 0.45, 10, 1, 19.413662},
    {"syamlal", 0.6, 100, 1, 31.8584924},
    {"syamlal", 0.75, 50, 1, 11.2506071},
    {"syamlal", 0.9, 1, 1, 2.00388266},
    {"syamlal", 0.95, 300, 1, 13.519325},
    {"syamlal", 0.5, 2000, 1, 698.252605},
    {"syamlal", 1, 40, 1, 3.21528794},
    {"schiller/naumann", 0.4, 0, 1, 2.5},
    {"schiller/naumann", 0.45, 10, 1, 5.02844243},
    {"schiller/naumann", 0.6, 100, 1, 10.0680364},
    {"schiller/naumann", 0.75, 50, 1, 4.91475371},
    {"schiller/naumann", 0.9, 1, 1, 1.29028889},
    {"schiller/naumann", 0.95, 300, 1, 9.28365503},
    {"schiller/naumann", 0.5, 2000, 1, 146.666667},
    {"schiller/naumann", 1, 40, 1, 2.89106507},
    {"stokes", 0.4, 0, 1, 2.5},
    {"stokes", 0.5, 2000, 1, 2},
    {"ergun/wenyu/jump", 0.4, 0, 1, 31.25},
    {"ergun/wenyu/jump", 0.45, 10, 1, 27.4348422},
    {"ergun/wenyu/jump", 0.6, 100, 1, 36.2654321},
    {"ergun/wenyu/jump", 0.75, 50, 1, 12.345679},
    {"ergun/wenyu/jump", 0.9, 1, 1, 1.68932295},
    {"ergun/wenyu/jump", 0.95, 300, 1, 10.3088483},
    {"ergun/wenyu/jump", 0.5, 2000, 1, 794.444444},
    {"ergun/wenyu/jump", 1, 40, 1, 2.89106507},
    {"beetstra/poly", 0.5, 10, 0.5, 13.3958153},
    {"beetstra/poly", 0.5, 10, 2, 53.2473038},
    {"beetstra/poly", 0.8, 100, 1, 13.7764307},
    {"beetstra/poly", 0.4, 0, 0.7, 27.3229255},
    {"beetstra/poly", 0.95, 300, 3, 32.5376403},
};

// Without it, a wrong constant, exponent or branch in any law would pass.
// Many particles at once: a vector function of the C library that is off near an edge (Re = 0, eps = 1, the joints of
// the laws), or a particle's F that hangs on its place among the others.
TEST(DragLaws, ManyAtOnceAreTheSame) {
  std::istringstream names(drag_law_names());
  double worst = 0;
  for (std::string name; names >> name;) {
    const DragLaw* law = find_drag_law(name);
    std::vector<double> eps, Re, y;
    for (double e : {0.2, 0.35, 0.4, 0.41, 0.6, 0.61, 0.799, 0.8, 0.85, 0.86, 0.9999, 1.0})
      for (double r : {0.0, 1e-8, 0.1, 1.0, 31.6, 40.0, 999.0, 1000.0, 3e4})
        eps.push_back(e), Re.push_back(r), y.push_back(0.5 + e);
    while (eps.size() % kDragBatch) eps.push_back(1), Re.push_back(0), y.push_back(1);
    const int n = int(eps.size());
    std::vector<double> F(n), again(n);
    law->F_of(n, eps.data(), Re.data(), y.data(), F.data());
    for (int q = 0; q < n; ++q) {
      const double one = law->F(eps[q], Re[q], y[q]);
      if (one == 0)
        EXPECT_EQ(F[q], 0) << name;
      else
        worst = std::max(worst, std::abs(F[q] / one - 1));
    }
    std::rotate(eps.begin(), eps.begin() + 3, eps.end());
    std::rotate(Re.begin(), Re.begin() + 3, Re.end());
    std::rotate(y.begin(), y.begin() + 3, y.end());
    law->F_of(n, eps.data(), Re.data(), y.data(), again.data());
    std::rotate(again.begin(), again.end() - 3, again.end());
    EXPECT_EQ(F, again) << name;
  }
  EXPECT_LE(worst, 1e-14);
  printf("             largest difference %.1e\n", worst);
}

TEST(Drag, LawsAgreeWithTheirPublishedFormulasEvaluatedIndependently) {
  double worst = 0;
  for (const Row& r : kTable) {
    const double value = F(r.law, r.eps, r.Re, r.y);
    EXPECT_NEAR(value / r.F, 1, 1e-7) << r.law << " eps " << r.eps << " Re " << r.Re << " y " << r.y;
    worst = std::max(worst, std::fabs(value / r.F - 1));
  }
  RecordProperty("worst_relative_difference", std::to_string(worst));
}

// Without it, a name in a script could select a different law, or a law go untested.
TEST(Drag, NamesFindTheirLawsAndNothingElse) {
  std::string all;
  for (const std::string& name : kNames) {
    const DragLaw* law = find_drag_law(name);
    ASSERT_NE(law, nullptr) << name;
    EXPECT_EQ(name, law->name);
    EXPECT_FALSE(std::string(law->reference).empty());
    all += (all.empty() ? "" : " ") + name;
  }
  EXPECT_EQ(drag_law_names(), all);
  EXPECT_EQ(find_drag_law("Ergun"), nullptr);
  EXPECT_EQ(find_drag_law("ergun/"), nullptr);
  EXPECT_EQ(find_drag_law(""), nullptr);
  EXPECT_EQ(find_drag_law("gidaspow")->F, find_drag_law("ergun/wenyu/jump")->F);
}

// Without it, F could be right by its own definition and b_p and beta still be off by eps or by a factor of slip.
// The coefficients are those of the momentum equation, written out in SI for air and for water.
TEST(Drag, CoefficientsOfErgunAndWenYuInSI) {
  struct Fluid {
    double rho, mu;
  };
  for (const Fluid fluid : {Fluid{1.2, 1.8e-5}, Fluid{1000, 1e-3}})
    for (double eps : {0.37, 0.55, 0.8, 0.97})
      for (double slip : {0.0, 1e-3, 0.2, 3.0})
        for (double d : {2e-4, 3e-3}) {
          const double eps_s = 1 - eps, n = eps_s / (kPi / 6 * d * d * d);
          const double beta_E = 150 * eps_s * eps_s * fluid.mu / (eps * d * d) + 1.75 * eps_s * fluid.rho * slip / d;
          const double Re = eps * fluid.rho * slip * d / fluid.mu;
          const double CD_slip = Re == 0     ? 24 * fluid.mu / (eps * fluid.rho * d)
                                 : Re < 1000 ? 24 / Re * (1 + 0.15 * std::pow(Re, 0.687)) * slip
                                             : 0.44 * slip;
          const double beta_WY = 0.75 * CD_slip * eps_s * eps * fluid.rho / d * std::pow(eps, -2.65);
          const auto beta = [&](const char* law) {
            return n * drag_coefficient(*find_drag_law(law), eps, d, slip, fluid.rho, fluid.mu, 1);
          };
          EXPECT_NEAR(beta("ergun") / beta_E, 1, 1e-12);
          EXPECT_NEAR(beta("wenyu") / beta_WY, 1, 1e-12);
          const double psi = std::atan(150 * 1.75 * (0.2 - eps_s)) / kPi + 0.5;
          EXPECT_NEAR(beta("ergun/wenyu") / ((1 - psi) * beta_E + psi * beta_WY), 1, 1e-12);
          EXPECT_NEAR(beta("ergun/wenyu/jump") / (eps < 0.8 ? beta_E : beta_WY), 1, 1e-12);
        }
}

// Without it, Ergun could be short of the eps between pressure drop and drag. The pressure drop of a bed of 0.8 mm
// spheres, void fraction 0.4, water at 1 mm/s superficial is 1338.867 Pa/m (C. Bell, library `fluids`, test of Ergun's
// equation); drag per volume is eps times that.
TEST(Drag, ErgunGivesATabulatedPressureDrop) {
  const double eps = 0.4, d = 8e-4, U = 1e-3, slip = U / eps;
  const double n = (1 - eps) / (kPi / 6 * d * d * d);
  const double b = drag_coefficient(*find_drag_law("ergun"), eps, d, slip, 1000, 1e-3, 1);
  EXPECT_NEAR(n * b * slip / eps, 1338.8671875, 1e-6);
}

// Without it, C_D of the lone sphere could be wrong in a way shared with the table above. Standard drag curve of the
// sphere as tabulated by Clift, Grace & Weber (1978) and by Morsi & Alexander (1972); Clift et al. state Schiller &
// Naumann's formula to be within +5 and -4 % of it up to Re = 800. Newton's 0.44 is good to 13 % from 750 to 3.5e5.
TEST(Drag, LoneSphereFollowsTheStandardDragCurve) {
  struct Point {
    double Re, C_D, tolerance;
  };
  const Point points[] = {{0.002, 12000.19, 0.05}, {0.5, 51.538, 0.05},    {5, 6.8998, 0.05},     {50, 1.57427, 0.05},
                          {50, 1.50003, 0.05},     {500, 0.554924, 0.05},  {500, 0.549948, 0.05}, {2500, 0.40818, 0.13},
                          {4e4, 0.46391, 0.13},    {7.5e4, 0.493999, 0.13}};
  for (const char* law : {"schiller/naumann", "wenyu"})
    for (const Point& p : points)
      EXPECT_NEAR(24 / p.Re * F(law, 1, p.Re) / p.C_D, 1, p.tolerance) << law << " Re " << p.Re;
}

// A suspension settles or is fluidised at U = U_t eps^n when its drag is eps V_p (rho_p - rho_f) g: 3 pi mu d U F
// there. Richardson & Zaki (1954) measured n = 4.65 at low and 2.39 at high Re; Garside & Al-Dibouni (1977) fitted 5.1
// at low Re. Without it, a law could carry the total force's exponent (one more) as the drag's: n would be off by 1 at
// low Re.
TEST(Drag, SuspensionsSettleWithTheMeasuredIndex) {
  const auto index = [](const char* law, double eps, bool viscous) {
    const double Re_t = viscous ? 0 : 5e4;
    const double weight = F(law, 1, Re_t) * (viscous ? 1 : Re_t);  // over eps
    double lo = 1e-6, hi = 1;                                      // U/U_t by bisection
    for (int i = 0; i < 200; ++i) {
      const double U = 0.5 * (lo + hi);
      (F(law, eps, viscous ? 0 : U * Re_t) * (viscous ? U : U * Re_t) < eps * weight ? lo : hi) = U;
    }
    return std::log(lo) / std::log(eps);
  };
  for (double eps : {0.5, 0.7, 0.9}) {
    EXPECT_NEAR(index("wenyu", eps, true), 4.65, 1e-9);
    EXPECT_NEAR(index("wenyu", eps, false), 2.39, 0.1);
    EXPECT_NEAR(index("difelice", eps, true), 4.65, 0.06);
    EXPECT_NEAR(index("difelice", eps, false), 2.39, 0.1);
    EXPECT_NEAR(index("syamlal", eps, true), 5.1, 0.05);
  }
}

// Koch & Hill, Beetstra and Tenneti are fits to simulations of the same thing, random arrays of spheres; their authors
// put them 10-30 % apart. Without it, radius for diameter (factor 2 in Re), total force for drag (factor 1/eps: 2 at
// 0.5), or a Re that is not superficial would pass if it were also in the table above.
TEST(Drag, CorrelationsOfRandomArraysAgreeOnceConverted) {
  for (double eps : {0.5, 0.6, 0.7}) {
    for (const char* law : {"kochhill", "tenneti"}) {
      EXPECT_NEAR(F(law, eps, 0) / F("beetstra", eps, 0), 1, 0.1) << law << " eps " << eps;
      EXPECT_NEAR(F(law, eps, 100) / F("beetstra", eps, 100), 1, 0.25) << law << " eps " << eps;
    }
  }
  // Carman (1937): pressure drop 180 mu U eps_s^2 / (eps^3 d^2), that is drag F = 10 eps_s / eps^2, packed beds.
  for (const char* law : {"kochhill", "beetstra", "tenneti", "ergun"})
    EXPECT_NEAR(F(law, 0.5, 0) / (10 * 0.5 / (0.5 * 0.5)), 1, 0.17) << law;
}

// Without it, 0/0 at eps = 1 or Re = 0, where every run starts, would show up as NaN forces.
TEST(Drag, FiniteEverywhereAndTakesItsLimits) {
  for (const std::string& name : kNames) {
    for (double eps : {0.2, 0.3, 0.4, 0.6, 0.8, 0.85, 0.95, 1 - 1e-12, 1.0, 1.0 + 2e-16})
      for (double Re : {0.0, 1e-300, 1e-12, 1e-3, 1.0, 999.9999, 1000.0, 1e5})
        for (double y : {0.3, 1.0, 3.0}) {
          const double f = F(name, eps, Re, y);
          EXPECT_TRUE(std::isfinite(f)) << name << " eps " << eps << " Re " << Re;
          EXPECT_GE(f, 0) << name << " eps " << eps << " Re " << Re;
        }
    for (double eps : {0.4, 0.9, 1.0}) {
      const double limit = F(name, eps, 0);
      EXPECT_NEAR(F(name, eps, 1e-14), limit, 1e-5 * limit + 1e-12) << name << " eps " << eps;
    }
    for (double Re : {0.0, 1.0, 500.0}) {
      const double limit = F(name, 1, Re);
      EXPECT_NEAR(F(name, 1 - 1e-14, Re), limit, 1e-4 * limit + 1e-12) << name << " Re " << Re;
    }
  }
  // A lone sphere at Re = 0 feels Stokes' drag; 4 % less where Dalla Valle's curve stands in for it.
  for (const char* law : {"wenyu", "ergun/wenyu/jump", "ergun/wenyu/rescaled", "gidaspow", "kochhill", "beetstra",
                          "tenneti", "schiller/naumann", "stokes"})
    EXPECT_NEAR(F(law, 1, 0), 1, 1e-14) << law;
  EXPECT_NEAR(F("beetstra/poly", 1, 0), 1.064, 1e-14);
  EXPECT_NEAR(F("difelice", 1, 0), 0.96, 1e-14);
  EXPECT_NEAR(F("syamlal", 1, 0), 0.96, 1e-14);
  EXPECT_EQ(F("ergun", 1, 0), 0);
}

// Without it, the default law's share of Ergun on a lone particle (its known defect) and the cure could be exchanged.
TEST(Drag, JointOfErgunAndWenYuAtItsEnds) {
  for (double Re : {0.0, 30.0, 5000.0}) {
    const double psi0 = 0.99393768763743;  // atan(52.5)/pi + 1/2
    EXPECT_NEAR(F("ergun/wenyu", 1, Re), (1 - psi0) * F("ergun", 1, Re) + psi0 * F("wenyu", 1, Re), 1e-12 * (1 + Re));
    EXPECT_NEAR(F("ergun/wenyu/rescaled", 1, Re) / F("wenyu", 1, Re), 1, 1e-14);
    for (double eps : {0.35, 0.45, 0.59}) EXPECT_EQ(F("ergun/wenyu/rescaled", eps, Re), F("ergun", eps, Re));
    const double half = 0.5 * (F("ergun", 0.8, Re) + F("wenyu", 0.8, Re));
    EXPECT_NEAR(F("ergun/wenyu", 0.8, Re) / half, 1, 1e-12);
    EXPECT_NEAR(F("ergun/wenyu/rescaled", 0.8, Re) / half, 1, 1e-12);
  }
}

// Without it, a branch taken on the wrong side, or a joint that isn't one, would pass the spot checks.
TEST(Drag, ContinuousWhereItClaimsToBe) {
  const auto jump = [](const char* law, double eps, double Re) {
    return F(law, eps + 1e-10, Re) / F(law, eps - 1e-10, Re) - 1;
  };
  for (double Re : {0.0, 10.0, 300.0, 1e4}) {
    for (const char* law : {"ergun/wenyu", "ergun/wenyu/rescaled", "difelice", "beetstra", "tenneti", "wenyu", "ergun"})
      for (double eps : {0.4, 0.6, 0.8, 0.85, 0.95}) EXPECT_NEAR(jump(law, eps, Re), 0, 1e-6) << law << " eps " << eps;
    EXPECT_NEAR(jump("ergun/wenyu/jump", 0.8, Re), F("wenyu", 0.8, Re) / F("ergun", 0.8, Re) - 1, 1e-6);
    // Steps that are the sources' own: 0.05 % in B of Garside & Al-Dibouni, 1 % between the branches of F0.
    EXPECT_LT(std::fabs(jump("syamlal", 0.85, Re)), 2e-3);
    EXPECT_LT(std::fabs(jump("kochhill", 0.6, Re)), 0.0106);
  }
  EXPECT_NEAR(jump("ergun/wenyu/jump", 0.8, 100), 10.27 / 17.80 - 1, 1e-3);  // it does jump
  EXPECT_GT(std::fabs(jump("kochhill", 0.6, 0)), 0.009);
  // C_D of the lone sphere: 0.4 %, upwards, at Re = 1000.
  EXPECT_NEAR(F("wenyu", 1, 1000) / F("wenyu", 1, 1000 - 1e-9) - 1, 0.0038, 2e-4);
}

// Without it, a law could have a force that falls as the slip grows: two slips for one weight, and an unstable bed. F
// itself need not grow: Di Felice's exponent dips at Re = 32.
TEST(Drag, ForceGrowsWithSlip) {
  for (const std::string& name : kNames)
    for (double eps : {0.25, 0.4, 0.5, 0.7, 0.84, 0.86, 0.99, 1.0}) {
      double last = 0;
      for (double Re = 1e-4; Re < 1e5; Re *= 1.05) {
        const double force = Re * F(name, eps, Re);
        EXPECT_GT(force, last) << name << " eps " << eps << " Re " << Re;
        last = force;
      }
    }
}

// Without it, size classes could take their own Re in place of the mixture's, or the printed factor of the total force
// could be used for the drag: too large by eps_s y^2 F, which a caller of formulation A would count twice.
TEST(Drag, PolydisperseForceFollowsTheSizeAtTheMixturesReynoldsNumber) {
  for (double eps : {0.4, 0.7})
    for (double mean_Re : {0.0, 5.0, 200.0})
      for (double y : {0.25, 0.5, 1.0, 2.0, 4.0}) {
        const double mono = F("beetstra", eps, mean_Re);
        EXPECT_NEAR(F("beetstra/poly", eps, y * mean_Re, y) / mono, y + 0.064 * y * y * y, 1e-12 * (1 + y * y * y));
        // Total force, as printed in 2005: times eps it is (eps y + eps_s y^2 + 0.064 eps y^3) F.
        const double total = eps * F("beetstra/poly", eps, y * mean_Re, y) + (1 - eps) * y * y * mono;
        EXPECT_NEAR(total / mono, eps * y + (1 - eps) * y * y + 0.064 * eps * y * y * y, 1e-12 * (1 + y * y * y));
      }
}

}  // namespace
}  // namespace twogrid
