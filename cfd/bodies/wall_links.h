// What the walls do to the faces' momentum: links between faces that no wall parts, friction, and the surface itself.
// The velocity of a face is that of its open part, which its flux asks for and which a uniform flow past a slip wall
// needs; friction and links ask for the one at its centre, which beside a wall that holds the fluid is nearer to zero, as
// the centre is nearer to the wall. With the closure of the open volumes' sides shear is so exact; for what bends a profile
// the viscous forces on a face stand for the volume between half ways to its neighbours and to the wall.
#pragma once

#include "cfd/bodies/cut_faces.h"

namespace twogrid {

class WallLinks {
 public:
  /// alpha, theta: cleaned, on the faces and cells of LocalGrid; beside_sheets: of its cells. All must outlive this.
  WallLinks(const LocalGrid& grid, const Surfaces& surfaces, const CutEdges& edges, const CutFaces& faces,
            const FaceField<FineGrid>& alpha, const CellField<FineGrid>& theta, const Array3<char>& beside_sheets);

  /// Fills links, centre, viscous, slivers, pieces and surface, and where walls move what is beside them.
  void fill(OpenSpace& space) const;

 private:
  enum class Node : unsigned char { kClosed, kFluid, kSliver };
  static constexpr double kLeast = 0.01;  ///< of a cell's width: nothing is nearer to a wall

  static constexpr double kLeastViscous = 0.5, kMostViscous = 2;  ///< 0.95 to 1.38 beside planes

  bool is_cut(int d, Int3 face) const;  ///< whether one of the cells beside a face is touched by a surface
  /// Sum of open areas times outward normals of a cell's faces (m2): minus that of its walls.
  Vec3 wall_area(const Int3& cell) const;
  double wall_size(const Int3& cell) const;
  double way(int c, const Int3& face, int d, bool up) const;
  double aperture(int c, const Int3& face, int d, bool up) const;
  void link(int c, const Int3& face, int d, bool up, double centre, unsigned char& bits, OpenSpace& space) const;
  /// The wall nearest to the open part of a face; its distance is at least kLeast.
  Surfaces::Foot wall_near(int c, const Int3& face) const;
  double centre(int c, const Int3& face) const;
  double viscous(int c, const Int3& face, unsigned char bits) const;
  Sliver sliver(int c, const Int3& face) const;
  void own_wall(int c, const Int3& face, OpenSpace& space) const;
  void add(std::vector<WallPiece>& pieces, int body, int c, const Int3& face, double conductance, const Vec3& point,
           const Vec3& shift) const;
  /// Of the wall nearest to a face: its motion goes on as a rigid body's.
  struct Rigid {
    int body;
    Vec3 shift;  // of its image
  };
  Rigid rigid(int c, const Int3& face) const;
  Vec3 velocity(const Rigid& of, const Vec3& x) const;
  /// Where a face's velocity is: its centre, or that of its open part.
  Vec3 place(int c, const Int3& face) const;
  bool near_cut(int c, const Int3& face) const;
  void beside_moving(int c, const Int3& face, OpenSpace& space) const;
  /// The wall nearest to a face, if it blows there, and its normal into the fluid.
  struct Blowing {
    int body = -1;
    Vec3 normal{0, 0, 0};
  };
  Blowing blowing(int c, const Int3& face) const;
  Vec3 blown_at_centre(int c, const Int3& face, const Blowing& beside, double centre) const;
  bool blows(int body, const Vec3& point, const Vec3& shift) const;
  double blown_share(const Int3& cell, int body) const;
  Vec3 normal_at(const Vec3& point, int body, const Vec3& about, double width) const;
  double least_width(int c, const Int3& face) const;
  void blow_piece(const WallPiece& piece, const Blowing& beside, const Vec3& shift, const Vec3& towards, double centre,
                  OpenSpace& space) const;
  void blow_sliver(const Sliver& sliver, OpenSpace& space) const;
  void blow_face(int c, const Int3& face, OpenSpace& space) const;

  const LocalGrid& grid_;
  const Surfaces& surfaces_;
  const CutFaces& faces_;
  const FaceField<FineGrid>& alpha_;
  const CellField<FineGrid>& theta_;
  const Array3<char>& beside_sheets_;
  Array3<unsigned char> cut_;
  std::array<Array3<Node>, 3> node_;
  bool moving_ = false, blowing_ = false;  // some wall
};

}  // namespace twogrid
