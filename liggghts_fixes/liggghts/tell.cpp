#include "liggghts_fixes/liggghts/tell.h"

#include <comm.h>
#include <lammps.h>

#include <cstdio>

#include "liggghts_fixes/run/still_files.h"

namespace twogrid {

void tell(LAMMPS_NS::LAMMPS& lammps, const std::string& text) {
  if (lammps.comm->me != 0) return;
  for (FILE* file : {files_are_still() ? stdout : lammps.screen, lammps.logfile})
    if (file) std::fputs(text.c_str(), file), std::fflush(file);
}

}  // namespace twogrid
