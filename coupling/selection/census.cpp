#include "coupling/selection/census.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "cfd/parallel/reduction.h"

namespace twogrid {

void survey_leaving(const Particles& p, const Selection& selection, double interval, Survey& mine) {
  for (int i : selection.leaving())
    for (int d = 0; d < 3; ++d) {
      const double impulse = p.step[i][kImpulse + d];
      mine.impulse[d] += impulse;
      mine.impulse_size += std::abs(impulse);
      mine.reaction = std::max(mine.reaction, std::abs(impulse) / interval);
      mine.finite = mine.finite && std::isfinite(impulse + p.x[i][d] + p.v[i][d]);
    }
}

double growth(const Particles& p, const Selection& selection) {
  double grown = 0;
  for (const std::vector<int>* list : {&selection.inside(), &selection.leaving()})
    for (int i : *list) {
      double* s = p.state[i];
      if (s[kVoidFraction] != 0 && p.radius[i] != s[kRestRadius])
        grown += sphere_volume(p.radius[i]) - sphere_volume(s[kRestRadius]);
      s[kRestRadius] = p.radius[i];
    }
  return grown;
}

Census take_census(MPI_Comm comm, const Particles& p, const Selection& selection, const Survey& mine, double grown,
                   double node_volume) {
  double inside = double(selection.inside().size()), leaving = double(selection.leaving().size());
  double new_particles = double(mine.new_particles), uncovered = 0, not_finite = 0, bad_tag = -1;
  double in_walls = double(selection.in_walls()), behind_walls = double(selection.behind_walls());
  double tag_behind = double(selection.tag_behind());
  if (!mine.finite || !selection.covered()) bad_tag = double(selection.find_bad(p, not_finite, uncovered));
  Census all;
  all.radius = mine.radius, all.mass = mine.mass, all.reaction = mine.reaction, all.response = mine.response;
  all.flux_velocity = mine.flux_velocity, all.grown = grown;
  double minus_radius = mine.minus_radius;
  Reduction::over_ranks(
      comm,
      {&all.radius, &minus_radius, &all.mass, &all.reaction, &all.response, &all.flux_velocity, &bad_tag, &tag_behind},
      {&inside, &new_particles, &uncovered, &not_finite, &leaving, &all.grown, &in_walls, &behind_walls});
  const std::string one_of_them = ", one of them tag " + std::to_string((long long)bad_tag);
  if (not_finite > 0)
    throw std::runtime_error(std::to_string((long long)not_finite) +
                             " particles have a position, velocity or impulse that is not finite" + one_of_them +
                             ". It became so since the last coupling: by a contact (a timestep too long for its "
                             "stiffness and damping, or two spheres in one place), or by the drag; reduce timestep or "
                             "every");
  if (uncovered > 0)
    throw std::runtime_error(std::to_string((long long)uncovered) + " particles lie further than " +
                             std::to_string(selection.reach()) + " m outside their rank's box" + one_of_them +
                             ": let the neighbour lists be rebuilt more often, or reduce timestep");
  all.smallest_radius = -minus_radius;
  all.particles = (long long)inside;
  all.in_walls = (long long)in_walls, all.behind_walls = (long long)behind_walls;
  all.tag_behind = (long long)tag_behind;
  all.new_particles = (long long)new_particles;
  // Most particles a node's sum can hold: all of them, or what sixteen times its volume holds; and those that leave.
  const double smallest = inside > 0 ? sphere_volume(all.smallest_radius) : 1.0;
  all.terms = std::max(1.0, std::min(inside, 16 * (node_volume / smallest + 1)) + leaving);
  return all;
}

}  // namespace twogrid
