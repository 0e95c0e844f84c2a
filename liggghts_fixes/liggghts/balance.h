// Particles shared out evenly: the borders between LIGGGHTS' ranks follow them.
//
// LIGGGHTS cuts the box into equal parts. A bed that lies in a part of it then leaves ranks without work. Borders are
// moved, direction by direction, to where as many particles lie in every part, and no further at a time than a rank's
// neighbours reach, since LIGGGHTS exchanges particles between neighbours only; the rest follows at the next times.
#pragma once

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

class Balance {
 public:
  /// Borders are moved where the fullest rank has more than so many times the mean of particles.
  static constexpr double kTolerated = 1.15;
  /// DEM steps between two looks, at least.
  static constexpr long kEvery = 1000;

  explicit Balance(LAMMPS_NS::LAMMPS& lammps) : lammps_(lammps) {}

  /// Before particles are exchanged: looks whether it is time, and moves borders. True: they have moved, LIGGGHTS'
  /// communication and bins have been set up for it. Collective.
  bool move_borders();
  /// Of the fullest rank, particles over the mean, as it was found last; 1 before.
  double fullest() const { return fullest_; }
  /// Whether no fix keeps anything of the ranks' parts of the box.
  bool can_be_moved() const;

  /// What one look leaves to the next, apart from the borders: f(name, entry). S: Balance or const Balance.
  template <class S, class F>
  static void for_each_entry(S& s, F&& f) {
    f("moving", s.moving_), f("next", s.next_);
  }

 private:
  double find_fullest() const;

  LAMMPS_NS::LAMMPS& lammps_;
  bool moving_ = false;  // not all the way yet
  long long next_ = 0;   // step from which on to look again
  double fullest_ = 1;
};

}  // namespace twogrid
