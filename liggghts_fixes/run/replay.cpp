#include "liggghts_fixes/run/replay.h"

namespace twogrid {

namespace {
bool is_replaying = false;
}  // namespace

bool replaying() {
  return is_replaying;
}

void set_replaying(bool on) {
  is_replaying = on;
}

}  // namespace twogrid
