#include "coupling/particles/ledger.h"

namespace twogrid {

std::array<double, 10> Ledger::own() const {
  std::array<double, 10> mine;
  for (int d = 0; d < 3; ++d) {
    mine[d] = action[d].value() + reaction[d].value() + wall[d].value();
    mine[3 + d] = wall[d].value();
  }
  // A rank's own difference is not small: its particles act on faces that others own. Only the sum over ranks is.
  mine[6] = magnitude.value();
  mine[7] = particle_volume.value();
  mine[8] = deposited_volume.value() - mine[7];
  mine[9] = inserted_volume.value();
  return mine;
}

Ledger::Balance Ledger::balance(const std::array<double, 10>& all) {
  Balance b;
  const double off = std::sqrt(all[0] * all[0] + all[1] * all[1] + all[2] * all[2]);
  b.momentum_error = all[6] > 0 ? off / all[6] : 0.0;
  b.solid_volume = all[7];
  b.inserted_volume = all[9];
  b.volume_error = all[7] > 0 ? std::abs(all[8]) / all[7] : 0.0;
  for (int d = 0; d < 3; ++d) b.wall[d] = all[3 + d];
  return b;
}

}  // namespace twogrid
