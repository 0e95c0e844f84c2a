// What the lists of a state's entries share (cfd/fluid/fluid_state.h, coupling/coupling_state.h): an array is shown by its
// own type, which tells what it is a field of, and a vector's components by a name each.
#pragma once

#include <array>

#include "cfd/grid/field.h"

namespace twogrid {

template <class Field, class F>
void show_array(const char* name, Field& a, F&& f) {
  f(name, a);
}
template <class Field, class F>
void show_components(Field& field, const std::array<const char*, 3>& names, F&& f) {
  for (int d = 0; d < 3; ++d) show_array(names[d], field[d], f);
}

}  // namespace twogrid
