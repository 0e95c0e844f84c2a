// Named methods: how volume is deposited, how the void fraction is prolonged and what a particle reads, as the
// literature and the studies combine them (cases/studies). A name sets the three choices; each may still be set by
// itself.
#pragma once

#include <string>

#include "coupling/settings.h"

namespace twogrid {

struct Method {
  const char* name;
  Deposit deposit;
  Prolong prolong;
  Read read;
  bool one_grid;          ///< the particles are seen on the fine cells: ratio 1 1 1
  const char* length;     ///< of deposit and read cube, or read kernel: what the word after the name is; null: none
  const char* reference;  ///< source, or what it is for
};

/// The default: right in gas and in liquids (cases/studies/default_method).
constexpr char kDefaultMethod[] = "smooth";

/// The method of this name, or null. Lives as long as the program.
const Method* find_method(const std::string& name);
/// All names, separated by blanks.
std::string method_names();
/// Sets deposit, prolong and read. length (m): of the method that wants one.
void choose(const Method& method, double length, Settings& settings);

}  // namespace twogrid
