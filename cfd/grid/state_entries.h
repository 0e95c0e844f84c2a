// What the lists of a state's entries share (cfd/fluid/fluid_state.h, coupling/coupling_state.h): an array is shown as
// Array3, whatever it is a field of, and a vector's components by a name each.
#pragma once

#include <array>

#include "cfd/grid/box.h"

namespace twogrid {

template <class F>
void show_array(const char* name, Array3<double>& a, F&& f) {
  f(name, a);
}
template <class F>
void show_array(const char* name, const Array3<double>& a, F&& f) {
  f(name, a);
}
template <class Field, class F>
void show_components(Field& field, const std::array<const char*, 3>& names, F&& f) {
  for (int d = 0; d < 3; ++d) show_array(names[d], field[d], f);
}

}  // namespace twogrid
