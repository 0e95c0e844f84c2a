// Bodies that can't be, in sentences, the same on all ranks; and those that look as if.
// What would pass falsely without it: a body left out without a word, an inlet that blows into steel, a chamber whose gas
// has no way out, fluid on the wrong side of a vessel's wall.
#include <gtest/gtest.h>

#include "tests/unit/cfd/cut_scene.h"

namespace twogrid {
namespace {

CutScene scene(std::vector<Body> bodies) {
  CutScene s(nodes_of({16, 16, 16}), {false, false, false}, std::move(bodies));
  s.side(kZlo, BoundaryKind::kInlet).side(kZhi, BoundaryKind::kPressure);
  return s;
}
void expect(CutScene s, const char* words) {
  const std::string found = s.sentence();
  if (*words)
    EXPECT_NE(found.find(words), std::string::npos) << "wanted: " << words << "\nfound: " << found;
  else
    EXPECT_EQ(found, "");
}

}  // namespace

TEST(BodyRefusals, WhatSeparatesNothing) {
  // A cup without thickness; a vessel's wall that ends within the domain; a sheet.
  std::vector<Triangle> cup = box_mesh({0.31, 0.32, 0.33}, {0.71, 0.72, 0.73});
  cup.resize(10);
  expect(scene({mesh(cup, "cup")}), "body 'cup' parts nothing: there is fluid on both sides of its surface at (");
  expect(scene({mesh(tube_mesh(2, {0.5, 0.5, 0}, 0.41, -0.1, 0.81, 64), "tube")}), "body 'tube' parts nothing");
  expect(scene({mesh(box_mesh({2.1, 2.1, 2.1}, {3, 3, 3}), "far")}), "body 'far' lies outside the fluid's domain");
  expect(scene({mesh(box_mesh({0.501, 0.501, 0.501}, {0.511, 0.511, 0.511}), "grain")}),
         "body 'grain' is met by no edge of the fluid's grid: it is thinner than a cell");
  // A plate of half a cell, which parts the box in two with inlet and outlet, and a rod of a third of a cell.
  expect(scene({mesh(box_mesh({-1, 0.51, -1}, {2, 0.54, 2}), "plate")})
             .fluid_at({0.5, 0.2, 0.5})
             .fluid_at({0.5, 0.8, 0.5}),
         "body 'plate' is thinner than a cell");
  expect(scene({body(std::make_shared<CylinderShape>(Vec3{0.52, 0.53, 0}, Vec3{0.01, 0, 1}, 0.01), "rod")})
             .fluid_at({0.1, 0.1, 0.1}),
         "body 'rod' is met by no edge");
  // Nothing thin: a ball grazes edges, a plate's one side is no fluid, a wall in a side's plane is the side's.
  expect(scene({mesh(box_mesh({-1, 0.51, -1}, {2, 0.54, 2}), "plate")}).fluid_at({0.5, 0.2, 0.5}), "");
  expect(scene({body_of<SphereShape>(Vec3{0.5, 0.5, 0.5}, 0.3128, FluidIs::kOutside),
                mesh(box_mesh({-1, -1, -1}, {2, 0, 2}), "side")}),
         "");
  // A tube and a ball that touch planes of the grid's nodes.
  for (FluidIs fluid : {FluidIs::kOutside, FluidIs::kUnknown})
    for (double radius : {0.13, 0.17, 0.21}) {
      expect(scene({body(std::make_shared<CylinderShape>(Vec3{0.5 - radius, 0, 0.53}, Vec3{0, 1, 0}, radius, fluid))})
                 .fluid_at({0.9, 0.9, 0.9}),
             "");
      expect(scene({body_of<SphereShape>(Vec3{0.5, 0.53, 0.5 - radius}, radius, fluid)}).fluid_at({0.9, 0.9, 0.9}), "");
    }
}

TEST(BodyRefusals, AnEdgeOfAMeshTouchesAnEdgeOfTheGrid) {
  // Along y, its rim of largest x in a plane of nodes, half way between two of them; then a cup there, which is one still.
  const double middle = 8.5 / 16;
  for (double radius : {0.13, 0.17, 0.21})
    for (double z : {middle, middle + 1e-9, 0.53})
      expect(
          scene({mesh(tube_mesh(1, {0.5 - radius, -0.1, z}, radius, -0.1, 1.1, 64), "tube")}).fluid_at({0.9, 0.9, 0.9}),
          "");
  std::vector<Triangle> cup = box_mesh({0.31, 0.32, 0.33}, {0.5, 0.72, 0.73});
  cup.resize(10);
  expect(scene({mesh(cup, "cup"), body_of<SphereShape>(Vec3{0.3, 0.5, 0.5}, 0.1, FluidIs::kOutside)})
             .fluid_at({0.9, 0.9, 0.9}),
         "body 'cup' parts nothing");
}

TEST(BodyRefusals, WhichSide) {
  // A tube from side to side whose ends are an inlet and an outlet, as what is around it.
  const Body tube = mesh(tube_mesh(2, {0.5, 0.5, 0}, 0.31, 0, 1, 64), "tube");
  expect(scene({tube}), "which side of the bodies' surfaces the fluid is on can't be told");
  expect(scene({tube}), "fluid_at");
  expect(scene({tube}).fluid_at({0.5, 0.5, 0.5}), "");
  expect(scene({tube}).fluid_at({0.1, 0.1, 0.5}), "");
  expect(scene({tube}).fluid_at({0.5, 0.5, 1.5}), "fluid_at (0.5 0.5 1.5) lies outside the fluid's domain");
  expect(scene({body_of<SphereShape>(Vec3{0.5, 0.5, 0.5}, 0.3, FluidIs::kOutside)}).fluid_at({0.5, 0.5, 0.5}),
         "fluid_at (0.5 0.5 0.5) lies in a body's solid");
  // A closed mesh in a box with inlet and outlet: what is around it, however its triangles are turned.
  for (bool mixed : {false, true}) {
    CutScene s = scene({mesh(box_mesh({0.31, 0.32, 0.33}, {0.71, 0.72, 0.73}, mixed), "box")});
    s.run();
    EXPECT_NEAR(s.report.bodies[0].volume, 0.4 * 0.4 * 0.4, 0.004);
  }
  // Bodies that overlap, and one within another.
  CutScene s = scene({mesh(box_mesh({0.31, 0.32, 0.33}, {0.71, 0.72, 0.73}), "box"),
                      mesh(box_mesh({0.51, 0.42, 0.43}, {0.91, 0.62, 0.63}), "other"),
                      body_of<SphereShape>(Vec3{0.5, 0.5, 0.5}, 0.09)});
  s.run();
  EXPECT_NEAR(1 - s.report.open_volume, 0.064 + 0.2 * 0.2 * 0.2, 0.005);
  EXPECT_EQ(s.report.bodies[2].area, 0);
  EXPECT_NEAR(s.report.bodies[0].volume + s.report.bodies[1].volume + s.report.bodies[2].volume,
              1 - s.report.open_volume, 1e-12);
  // Nothing tells in a closed box.
  CutScene closed(nodes_of({16, 16, 16}), {false, false, false}, {body_of<SphereShape>(Vec3{0.5, 0.5, 0.5}, 0.3)});
  expect(closed, "reach no inlet or outlet");
}

TEST(BodyRefusals, InletsOutletsAndPockets) {
  // The inlet below lies behind the solid.
  expect(scene({body_of<PlaneShape>(Vec3{0, 0, 0.33}, Vec3{0, 0, 1})}), "cover the inlet on side zlo wholly");
  CutScene patch = scene({body_of<PlaneShape>(Vec3{0.4, 0, 0}, Vec3{1, 0, 0})});
  BoundaryCondition jet;
  jet.name = "jet", jet.kind = BoundaryKind::kInlet;
  jet.shape.kind = PatchShape::Kind::kRectangle, jet.shape.value = {0, 0.3, 0, 1};
  patch.settings.side[kZlo][0].kind = BoundaryKind::kNoSlip;
  patch.settings.side[kZlo].push_back(jet);
  expect(patch, "cover the inlet 'jet' on side zlo wholly");
  // A chamber over the inlet, closed by a slab: the gas has no way out.
  CutScene slab = scene({mesh(box_mesh({-1, -1, 0.31}, {2, 2, 0.52}), "slab")});
  slab.fluid_at({0.5, 0.5, 0.1}).fluid_at({0.5, 0.5, 0.9});
  expect(slab, "an inlet leads into it");
  CutScene above = scene({mesh(box_mesh({-1, -1, 0.31}, {2, 2, 0.52}), "slab")});
  above.fluid_at({0.5, 0.5, 0.9});
  expect(above, "cover the inlet on side zlo wholly");
  // A hollow: closed, and its volume told.
  CutScene hollow = scene({body_of<SphereShape>(Vec3{0.5, 0.5, 0.5}, 0.4, FluidIs::kOutside)});
  hollow.run();
  EXPECT_EQ(hollow.report.pocket_volume, 0);
  CutScene two(nodes_of({16, 16, 16}), {false, false, false},
               {body_of<CylinderShape>(Vec3{0.5, 0.5, 0}, Vec3{0, 0, 1}, 0.5, FluidIs::kOutside)});
  two.side(kXlo, BoundaryKind::kPressure).side(kYlo, BoundaryKind::kPressure);
  two.run();  // four corners beside the cylinder; the one that no outlet is at is a pocket
  EXPECT_NEAR(two.report.pocket_volume, 0.25 * (1 - kPi / 4), 0.002);
  double open = 0;
  for (double theta : two.theta()) open += theta / (16 * 16 * 16);
  EXPECT_NEAR(open, 0.75 * (1 - kPi / 4), 0.006);
}

}  // namespace twogrid
