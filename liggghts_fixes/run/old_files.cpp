#include "liggghts_fixes/run/old_files.h"

#include <unistd.h>

#include <cstdio>

namespace twogrid {

void keep_file(const std::string& name) {
  if (access(name.c_str(), F_OK) != 0) return;
  int number = 1;
  while (access((name + "." + std::to_string(number)).c_str(), F_OK) == 0) ++number;
  std::rename(name.c_str(), (name + "." + std::to_string(number)).c_str());
}

}  // namespace twogrid
