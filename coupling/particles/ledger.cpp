#include "coupling/particles/ledger.h"

namespace twogrid {

std::array<double, 7> Ledger::own() const {
  std::array<double, 7> mine;
  for (int d = 0; d < 3; ++d) mine[d] = action[d].value() + reaction[d].value() + wall[d].value();
  // A rank's own difference is not small: its particles act on faces that others own. Only the sum over ranks is.
  mine[3] = magnitude.value();
  mine[4] = particle_volume.value();
  mine[5] = deposited_volume.value() - mine[4];
  mine[6] = inserted_volume.value();
  return mine;
}

Ledger::Balance Ledger::balance(const std::array<double, 7>& all) {
  Balance b;
  const double off = std::sqrt(all[0] * all[0] + all[1] * all[1] + all[2] * all[2]);
  b.momentum_error = all[3] > 0 ? off / all[3] : 0.0;
  b.solid_volume = all[4];
  b.inserted_volume = all[6];
  b.volume_error = all[4] > 0 ? std::abs(all[5]) / all[4] : 0.0;
  return b;
}

}  // namespace twogrid
