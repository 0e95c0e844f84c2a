#include "liggghts_fixes/run/replay.h"

namespace twogrid {

namespace {
bool is_replaying = false, is_restarting = false;
}  // namespace

bool replaying() {
  return is_replaying;
}

void set_replaying(bool on) {
  is_replaying = on;
}

bool restarting() {
  return is_restarting;
}

void set_restarting(bool on) {
  is_restarting = on;
}

}  // namespace twogrid
