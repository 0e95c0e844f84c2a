#include "liggghts_fixes/liggghts/watchers.h"

#include <fix.h>
#include <lammps.h>
#include <modify.h>

#include <algorithm>
#include <cstring>
#include <iterator>

namespace twogrid {

using namespace LAMMPS_NS;

bool any_watchers(LAMMPS& lammps) {
  const Modify* const modify = lammps.modify;
  static const char* const blind[] = {"twogrid",
                                      "nve/sphere",
                                      "gravity",
                                      "wall/gran",
                                      "freeze",
                                      "property/",
                                      "contacthistory",
                                      "particletemplate/",
                                      "insert/",
                                      "contactproperty/",
                                      "particledistribution/"};
  bool watchers = false;
  for (int f = 0; f < modify->nfix; ++f)
    watchers |= std::none_of(std::begin(blind), std::end(blind), [&](const char* style) {
      return std::strncmp(modify->fix[f]->style, style, std::strlen(style)) == 0;
    });
  return watchers;
}

}  // namespace twogrid
