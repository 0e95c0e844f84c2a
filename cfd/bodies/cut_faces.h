// The open parts of faces and cells, from the kinds of their corners and the crossings of their edges.
#pragma once

#include "cfd/bodies/cut_edges.h"
#include "cfd/bodies/fluid_vertices.h"

namespace twogrid {

class CutFaces {
 public:
  CutFaces(const CutEdges& edges, const FluidVertices& vertices) : edges_(edges), vertices_(vertices) {}

  /// Open share of a face's area, and the centroid of the open part: shares of the face's widths in the two directions
  /// that follow d.
  struct Open {
    double share = 0;
    std::array<double, 2> centroid{0.5, 0.5};
  };
  Open open(int d, const Int3& face) const;
  /// What bounds a face's open part: fluid corners and the first crossings from them, one after the other around it.
  struct Outline {
    using Point = std::array<double, 2>;  ///< shares of the face's widths in the two directions that follow d
    int n = 0;
    std::array<Point, 8> point;
    std::array<unsigned char, 8> from, to;  ///< a crossing on the way from a corner to another; the same: that corner
    bool parted = false;                    ///< two triangles at opposite corners, of three points each
    bool whole = false;                     ///< the surface meets its edges at their ends only
  };
  /// Empty where no corner is in the fluid.
  Outline outline(int d, const Int3& face) const;
  /// Whether an uncrossed way along the axes joins the face's centre to a corner in the fluid.
  bool fluid_centre(int d, const Int3& face) const;
  /// Open share of a cell's volume: the polyhedron of the open parts of its faces (of the given shares) and of a wall of
  /// triangles between the surface's points on its edges and their mean. That is the sum of pyramids from this mean.
  double open_share(const Int3& cell, const FaceField<FineGrid>& alpha) const;
  /// True where no edge of the cell is crossed away from its ends: walls, if any, lie in its faces.
  bool aligned(const Int3& cell) const;

 private:
  /// Corner of a face, bits as in CutEdges::joined_corners.
  VertexKind corner(int d, const Int3& face, unsigned q) const;
  /// Way from the low end of an edge, or from its high one, to the first crossing, as a share of its length; 1 without one.
  double reach(int d, const Int3& low, bool from_high) const;

  const CutEdges& edges_;
  const FluidVertices& vertices_;
};

}  // namespace twogrid
