#include "liggghts_fixes/liggghts/tell.h"

#include <comm.h>
#include <lammps.h>

#include <cstdio>

namespace twogrid {

void tell(LAMMPS_NS::LAMMPS& lammps, const std::string& text) {
  if (lammps.comm->me != 0) return;
  for (FILE* file : {lammps.screen, lammps.logfile})
    if (file) std::fputs(text.c_str(), file), std::fflush(file);
}

}  // namespace twogrid
