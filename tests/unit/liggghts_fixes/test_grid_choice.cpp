// fine, ratio auto: numbers of cells against values worked out by hand, and what is asked for is there.
// What would pass falsely without it: a jet on three cells, a tube on seven, particle cells smaller than a grain, a patch with a
// wrong area where another number of cells had the right one, a sentence whose advice ends in the next sentence: every run would go on, on a grid that isn't what was promised.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "cfd/bodies/simple_shapes.h"
#include "cfd/bodies/triangle_set.h"
#include "liggghts_fixes/report/body_widths.h"
#include "liggghts_fixes/report/grid_scene.h"
#include "liggghts_fixes/script/consistency.h"
#include "liggghts_fixes/script/grid_choice.h"

namespace twogrid {
namespace {

GridScene slot(double d) {
  GridScene s;
  s.domain = {0, 0.0216, 0, 0.0048, 0, 0.072};
  s.d = s.d_max = d;
  s.along = 2, s.flows = {false, false, true};
  return s;
}

Opening rect(int side, double a, double b, double c, double e) {
  Opening o;
  o.name = "patch jet", o.side = side, o.extent = {a, b, c, e};
  return o;
}

std::string sentence(const GridScene& s, const GivenGrids& given = {}) {
  try {
    choose_grids(s, given);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "no exception";
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

bool any(const GridChoice& c, const std::string& part) {
  for (const std::string& r : c.reasons)
    if (has(r, part)) return true;
  return false;
}

TEST(GridChoiceOf, ABareBedHasOneFineCellToAParticleCell) {
  // 18 d x 4 d x 60 d: 6 and 20 cells of 3 d; 4 d is less than two of them.
  const GridChoice c = choose_grids(slot(1.2e-3), {});
  EXPECT_EQ(c.fine, (Int3{6, 1, 20}));
  EXPECT_EQ(c.ratio, (Int3{1, 1, 1}));
  ASSERT_EQ(c.reasons.size(), 4u);
  EXPECT_TRUE(any(c, "grid y: 1 fine cell") && any(c, "less than two particle cells")) << c.reasons[2];
}

TEST(GridChoiceOf, AJetHasFourCellsOnSidesOfCells) {
  // 2.4 mm in the middle of 21.6 mm: cells of 0.6 mm, 36 of them, 6 to a particle cell of 3 d. The jet is then two halves of
  // particle cells 3 and 4; with an odd number its middle would lie in the middle of one, and none has edges on sides of cells.
  GridScene s = slot(1.2e-3);
  s.openings = {rect(kZlo, 0.0096, 0.0120, 0, 0.0048)};
  const GridChoice c = choose_grids(s, {});
  EXPECT_EQ(c.fine[0] % 9, 0);  // edges at 4/9 and 5/9 of the width
  EXPECT_GE(c.fine[0], 36);
  EXPECT_EQ(c.fine[1], 1);
  // Cells of 0.6 mm are at most 2.4 mm long: 30 of them at least along 72 mm.
  EXPECT_GE(c.fine[2], 30);
  EXPECT_TRUE(any(c, "4 across patch jet, 0.0024 m wide"));
}

TEST(GridChoiceOf, JetsAskWhereverTheyAre) {
  // On two sides: at zlo 4.8 mm along x, at xlo 1.6 mm along z and the whole depth.
  GridScene s = slot(1.2e-3);
  s.flows[0] = true;
  s.openings = {rect(kZlo, 0.0096, 0.0144, 0, 0.0048), rect(kXlo, 0, 0.0048, 0.02, 0.0216)};
  const GridChoice c = choose_grids(s, {});
  EXPECT_GE(c.fine[0], 18);
  EXPECT_GE(c.fine[2], 180);
  EXPECT_LE(c.fine[2], 220);
  EXPECT_EQ(c.fine[1], 1);
  // Half of the depth: 2.4 mm there, and 4 cells across them.
  s.openings = {rect(kZlo, 0.0096, 0.0144, 0, 0.0024)};
  EXPECT_EQ(choose_grids(s, {}).fine[1], 8);
}

TEST(GridChoiceOf, WallPatchesHaveTwoCells) {
  // A plate of 0.5 mm in cells of 3.6 mm would hold no face's centre.
  GridScene s = slot(1.2e-3);
  s.openings = {rect(kZlo, 0.003, 0.0035, 0, 0.0048)};
  s.openings[0].asks = false;
  const GridChoice c = choose_grids(s, {});
  EXPECT_GE(c.fine[0] * 0.0005 / 0.0216, 2 - 1e-9);
  EXPECT_LE(c.fine[0] * 0.0005 / 0.0216, 3.5);
  EXPECT_TRUE(any(c, "2 across patch jet, 0.0005 m wide"));
}

TEST(GridChoiceOf, OddPlacesKeepTheArea) {
  // Whole faces are taken, those whose centre the patch covers: of 2.3 mm at 7.13 mm within 2 % for the number that is chosen.
  for (double a : {0.0, 1.37e-3, 7.13e-3, 13.01e-3, 19.3e-3})
    for (double w : {1.1e-3, 2.3e-3}) {
      GridScene s = slot(1.2e-3);
      s.openings = {rect(kZlo, a, a + w, 0, 0.0048)};
      const int n = choose_grids(s, {}).fine[0];
      int taken = 0;
      for (int i = 0; i < n; ++i) {
        const double x = (i + 0.5) / n * 0.0216;
        taken += x > a && x < a + w;
      }
      EXPECT_GE(taken, 4) << a << " " << w;
      EXPECT_NEAR(taken * 0.0216 / n, w, 0.02 * w) << a << " " << w;
    }
}

TEST(GridChoiceOf, ACircleHasItsArea) {
  // Four cells a diameter have 12 faces inside where 12.57 are drawn, 4.5 % less: others are taken.
  GridScene s = slot(1e-3);
  s.domain = {0, 0.02, 0, 0.02, 0, 0.06};
  Opening o = rect(kZlo, 0.008, 0.012, 0.008, 0.012);
  o.kind = PatchShape::Kind::kCircle;
  s.openings = {o};
  const GridChoice c = choose_grids(s, {});
  int faces = 0;
  for (int j = 0; j < c.fine[1]; ++j)
    for (int i = 0; i < c.fine[0]; ++i)
      faces += std::hypot((i + 0.5) / c.fine[0] * 0.02 - 0.01, (j + 0.5) / c.fine[1] * 0.02 - 0.01) < 0.002;
  EXPECT_GE(c.fine[0], 20);
  EXPECT_GE(c.fine[1], 20);
  EXPECT_NEAR(faces * 4e-4 / c.fine[0] / c.fine[1], 3.14159265 * 4e-6, 0.02 * 3.15 * 4e-6);
}

TEST(GridChoiceOf, LargeGrainsAmongSmallOnesFillNoCell) {
  GridScene s = slot(1e-3);
  s.domain = {0, 0.036, 0, 0.012, 0, 0.150};
  s.d = 1.99e-3, s.d_max = 4.5e-3;  // 3 d are 5.97 mm, two of the largest 9 mm: 4 cells, one (12 mm), 16 of 9.4 mm
  const GridChoice c = choose_grids(s, {});
  EXPECT_EQ(c.fine, (Int3{4, 1, 16}));
  s.least = 1;  // exact deposit: one of the largest
  EXPECT_EQ(choose_grids(s, {}).fine, (Int3{6, 2, 25}));
}

TEST(GridChoiceOf, ThinDirectionsWithFlowOrFriction) {
  GridScene s = slot(1.2e-3);
  s.flows[1] = true;
  EXPECT_EQ(choose_grids(s, {}).fine[1], 2);
  s.rubs[1] = true;
  EXPECT_EQ(choose_grids(s, {}).fine[1], 4);
  EXPECT_EQ(choose_grids(s, {}).ratio[1], 4);
}

TEST(GridChoiceOf, AThinBedHasMoreCellsAlongGravity) {
  GridScene s = slot(1.2e-3);
  s.bed = 0.0241;  // 20 d, 8 cells of 2.5 d: 72 mm in 24 of them
  GridChoice c = choose_grids(s, {});
  EXPECT_EQ(c.fine[2], 24);
  EXPECT_TRUE(any(c, "lacks less than 5 % of its drag") && !c.end_told) << c.reasons[3];
  s.bed = 0.012;  // 10 d: 2 d it is, 30 cells, of which it has 5 in place of 8
  c = choose_grids(s, {});
  EXPECT_EQ(c.fine[2], 30);
  EXPECT_TRUE(any(c, "lacks about 8 % of its drag") && any(c, "not below 2 d") && c.end_told) << c.reasons[3];
  s.least = 1, s.bed_cells = 5.4, s.bed = 0.007;  // deposit exact: no smaller
  EXPECT_EQ(choose_grids(s, {}).fine[2], 30);
  s.least = 2, s.bed_cells = 8, s.bed = 0.012;
  EXPECT_EQ(choose_grids(s, {}).fine[0], 6);
}

TEST(GridChoiceOf, BodiesHaveEightCells) {
  GridScene s = slot(1e-3);
  s.widths.push_back({"solid tube, its diameter", {0.0054, 0, 0.0054}, 8});
  const GridChoice c = choose_grids(s, {});
  EXPECT_GE(c.fine[0] * 0.0054 / 0.0216, 8 - 1e-9);
  EXPECT_GE(c.fine[2] * 0.0054 / 0.072, 8 - 1e-9);
  EXPECT_LE(c.fine[0], 40);
  EXPECT_EQ(c.fine[1], 1);
  EXPECT_TRUE(any(c, "8 across solid tube"));
}

TEST(GridChoiceOf, WhatIsGivenStays) {
  GridScene s = slot(1.2e-3);
  GivenGrids given;
  given.fine = {36, 1, 60};  // 0.5 d and 1 d: 6 and 3 to a particle cell
  EXPECT_EQ(choose_grids(s, given).ratio, (Int3{6, 1, 3}));
  given.fine = {0, 1, 60}, given.ratio = {3, 0, 2};
  const GridChoice c = choose_grids(s, given);
  EXPECT_EQ(c.fine, (Int3{18, 1, 60}));
  EXPECT_EQ(c.ratio, (Int3{3, 1, 2}));
  // 61 is prime: cells of 0.98 d, or of 60 d.
  given = {}, given.fine = {0, 0, 61};
  EXPECT_TRUE(has(sentence(s, given), "61") && has(sentence(s, given), "60")) << sentence(s, given);
  // Stretched: the smallest particle cell is what counts.
  given = {}, given.fine = {36, 1, 60}, given.stretch = {1, 1, 1.01};
  const GridChoice stretched = choose_grids(s, given);
  const std::vector<double> node = graded_nodes(0, 0.072, 60, 1.01);
  EXPECT_GE(node[stretched.ratio[2]], 2 * 1.2e-3 * (1 - 1e-9));
}

TEST(GridChoiceOf, WhatASentenceWantsIsTaken) {
  // Stretched or not, thick or thin bed: each number of cells is taken, or another is named that is.
  int taken = 0, named = 0, none = 0;
  for (const double stretch : {1.0, 1.05, 0.97, 1.2})
    for (const double bed : {0.0, 0.01})
      for (int n = 1; n <= 90; ++n) {
        GridScene s = slot(1e-3);
        s.domain[5] = 0.08;
        s.bed = bed;
        GivenGrids given;
        given.fine = {0, 0, n}, given.stretch = {1, 1, stretch};
        const std::string said = sentence(s, given);
        if (said == "no exception") {
          ++taken;
          continue;
        }
        EXPECT_FALSE(stretch != 1 && has(said, "auto for fine in z, or")) << said;  // that isn't allowed with it
        EXPECT_TRUE(has(said, "a number for ratio")) << said;
        const auto at = said.find("wanted fine ");
        if (at == std::string::npos) {
          ++none;
          continue;
        }
        ++named;
        given.fine[2] = std::stoi(said.substr(at + 12));
        EXPECT_EQ(sentence(s, given), "no exception") << said;
      }
  EXPECT_GT(taken, 200);
  EXPECT_GT(named, 50);
  EXPECT_GT(none, 0);
  // 80 mm in 24 cells that grow by 1.05: of 1.8 mm at first, two of them 3.7 d.
  GridScene s = slot(1e-3);
  s.domain[5] = 0.08;
  GivenGrids given;
  given.fine = {0, 0, 24}, given.stretch = {1, 1, 1.05};
  EXPECT_EQ(choose_grids(s, given).ratio[2], 2);
}

TEST(GridChoiceOf, WhatCannotBeEndsInASentence) {
  GridScene s = slot(1.2e-3);
  s.domain = {0, 1, 0, 1, 0, 1};
  s.openings = {rect(kZlo, 0.5, 0.5001, 0.5, 0.5001)};
  EXPECT_TRUE(has(sentence(s), "40000 in x") && has(sentence(s), "patch jet") && has(sentence(s), "give numbers"))
      << sentence(s);
  s = slot(0);
  EXPECT_TRUE(has(sentence(s), "no particles nor templates")) << sentence(s);
  // A ratio that makes particle cells of 3 x 0.4 mm = 1 d of what a jet asks for.
  s = slot(1.2e-3);
  s.openings = {rect(kZlo, 0.0096, 0.0112, 0, 0.0048)};
  GivenGrids given;
  given.ratio = {3, 1, 1};
  EXPECT_TRUE(has(sentence(s, given), "at least 6 there")) << sentence(s, given);
  s.one_grid = true, s.method = "single";
  EXPECT_TRUE(has(sentence(s), "method single")) << sentence(s);
}

FineGrid cube(double L) {
  FineGrid g;
  for (Axis& a : g.axis) a = Axis(graded_nodes(0, L, 8), false);
  return g;
}

double width_of(const BodyMeasures& m, const std::string& what, int d) {
  for (const WidthAcross& w : m.widths)
    if (has(w.name, what) && w.size[d] > 0) return w.size[d];
  return 0;
}

constexpr std::array<bool, 6> kClosed{true, true, true, true, false, false};

TEST(BodyMeasuresOf, TubesChannelsAndGaps) {
  // A tube of 12 mm along y, 6 mm from the side xlo, in a box of 60 mm.
  const std::vector<Body> tube{
      {"tube", std::make_shared<CylinderShape>(Vec3{0.012, 0, 0.03}, Vec3{0, 1, 0}, 0.006, FluidIs::kOutside)}};
  BodyMeasures m = measure_bodies(tube, cube(0.06), kClosed, {}, 1e-3);
  EXPECT_NEAR(width_of(m, "its diameter", 0), 0.012, 1e-6);
  EXPECT_NEAR(width_of(m, "its diameter", 2), 0.012, 1e-6);
  EXPECT_EQ(width_of(m, "its diameter", 1), 0);
  EXPECT_NEAR(width_of(m, "gap", 0), 0.006, 2e-4);
  double open = 0;
  for (double v : m.open_layers[2]) open += v;
  EXPECT_NEAR(open, 0.06 * 0.06 * 0.06 - 3.14159265 * 36e-6 * 0.06, 0.03 * 216e-6);
  // The same as a vessel.
  const std::vector<Body> pipe{
      {"pipe", std::make_shared<CylinderShape>(Vec3{0.03, 0.03, 0}, Vec3{0, 0, 1}, 0.02, FluidIs::kInside)}};
  m = measure_bodies(pipe, cube(0.06), kClosed, {}, 1e-3);
  EXPECT_NEAR(width_of(m, "inner diameter", 0), 0.04, 1e-6);
  EXPECT_NEAR(width_of(m, "inner diameter", 1), 0.04, 1e-6);
}

TEST(BodyMeasuresOf, WhatIsAtAnAngle) {
  // A tube at 30 degrees in x and z: 12 mm/cos(30) and 12 mm/cos(60) along the axes; the latter is no part across it.
  const double c = std::cos(M_PI / 6), s = std::sin(M_PI / 6);
  const std::vector<Body> tube{
      {"tube", std::make_shared<CylinderShape>(Vec3{0.03, 0.03, 0.03}, Vec3{s, 0, c}, 0.006, FluidIs::kOutside)}};
  const BodyMeasures m = measure_bodies(tube, cube(0.06), kClosed, {}, 1e-3);
  EXPECT_NEAR(width_of(m, "its diameter", 0), 0.012 / c, 0.1 * 0.012);
  EXPECT_NEAR(width_of(m, "its diameter", 1), 0.012, 1e-6);
}

TEST(BodyMeasuresOf, WedgesThatNarrowToNothingAskForNothing) {
  // A plane at 45 degrees from one side to another: a wedge, as wide as you like.
  const std::vector<Body> chute{{"chute", std::make_shared<PlaneShape>(Vec3{0.03, 0, 0}, Vec3{-1, 0, 1})}};
  const BodyMeasures m = measure_bodies(chute, cube(0.06), {true, true, true, true, true, false}, {}, 1e-4);
  for (const WidthAcross& w : m.widths)
    for (int d = 0; d < 3; ++d) EXPECT_TRUE(w.size[d] == 0 || w.size[d] / w.cells > 2e-3) << w.name;
}

}  // namespace
}  // namespace twogrid
