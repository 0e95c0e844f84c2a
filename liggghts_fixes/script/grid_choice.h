// `fine auto`, `ratio auto`: numbers of cells from what a scene holds. A pure function, of lengths and shapes: the same on all
// ranks and on any number of them.
//
//   particle cells  3 d a side, 2.5 to 4, where that makes numbers of cells that suit the rest; d: GridScene::d, and at least two
//                   of the largest particles with deposit centroid or trilinear, one with others. Along gravity so many that a
//                   bed that ends in one lacks no more drag than the scene report's warning allows, but of 2 d at least. A direction of fewer than
//                   two of them is one cell, unless the fluid flows along it.
//   fine cells      one to a particle cell, but 4 across an opening, 2 across a patch that is a wall, 4 across a gap or 8 across a body, as GridScene::widths has
//                   it; no cell is more than 4 times as long as it is wide.
//
// Of the numbers that are allowed those are taken that have few cells, openings whose edges lie on sides of fine cells (a patch
// takes whole faces) and whose middles lie in the middle of a particle cell, and particle cells near 3 d.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "cfd/fluid_settings.h"

namespace twogrid {

/// Cells that openings must have across them, and bodies a diameter.
constexpr int kCellsAcrossOpening = 4, kCellsAcrossBody = 8;
/// And patches that are walls, so that they are there.
constexpr int kCellsAcrossWallPatch = 2;
/// More fine cells than these are no choice of ours.
constexpr double kMostChosenCells = 2e7;

/// A patch that is smaller than its side.
struct Opening {
  std::string name;  ///< for sentences: "patch jet of zlo"
  int side = kZlo;   ///< of the domain
  PatchShape::Kind kind = PatchShape::Kind::kRectangle;
  std::array<double, 4> extent{};              ///< lo hi lo hi in the side's two directions (m)
  bool asks = true;                            ///< something passes through: for more cells than a wall
  double area = 0;                             ///< of a region (m2)
  std::function<bool(double, double)> inside;  ///< of a region, of the two coordinates (m)
};

/// A length of a body, or between bodies, that wants cells across it.
struct WidthAcross {
  std::string name;            ///< for sentences: "solid tube, 0.012 m across"
  std::array<double, 3> size;  ///< along x, y, z (m); 0: no demand
  int cells = kCellsAcrossBody;
};

/// What the choice goes by.
struct GridScene {
  std::array<double, 6> domain{};  ///< m
  double d = 0;                    ///< of equal spheres that make as rough a void fraction (m)
  double d_max = 0;                ///< m
  std::string d_text;              ///< where the two come from, in words
  double least = 2;             ///< particle cells, in d_max: 2, 1, or 0 where the void fraction doesn't hang on them
  double least_common = 2.5;    ///< and in d, but along gravity in a thin bed
  double bed = 0;               ///< height of the settled bed (m); 0: unknown, or none
  int along = -1;               ///< direction of gravity
  double bed_cells = 8;         ///< particle cells that this height wants
  double bed_missing = 0.05;    ///< share of its drag that it then lacks
  std::array<bool, 3> flows{};  ///< a component of the velocity is needed: 2 fine cells at least
  std::array<bool, 3> rubs{};   ///< a side has noslip: 4 at least
  bool one_grid = false;        ///< particles are seen on the fine cells
  std::string method;           ///< for sentences
  double kernel = 0;            ///< width that particles read over (m), 2 cells at least; 0: none
  std::vector<Opening> openings;
  std::vector<WidthAcross> widths;
};

/// What the script has said. 0: auto.
struct GivenGrids {
  Int3 fine{0, 0, 0}, ratio{0, 0, 0};
  std::array<double, 3> stretch{1, 1, 1};
  std::array<bool, 3> symmetric{};
};

struct GridChoice {
  Int3 fine{1, 1, 1}, ratio{1, 1, 1};
  std::vector<std::string> reasons;  ///< lines of the scene report, "name: text"
  bool end_told = false;             ///< among them, that a bed lacks more drag at its end than is wanted
};

/// Throws std::invalid_argument with a sentence where there is no such choice.
GridChoice choose_grids(const GridScene& scene, const GivenGrids& given);

}  // namespace twogrid
