// Models: parts of the physics that a script switches on, `fix_modify ID model NAME keyword value ...`. A model's
// equations, its state and its step stand in a file of its own in cfd/ or coupling/, with its numbers as a member of
// FluidSettings or Settings; what a script and a report say of it, in a file of its own in models/. To add one: those
// two files, that member, one call where its step belongs, and its line in models.cpp.
#pragma once

#include <string>
#include <vector>

#include "liggghts_fixes/script/keywords.h"

namespace twogrid {

struct Model {
  std::string name;               ///< first word of all its keywords
  std::vector<Keyword> keywords;  ///< its rows: words "NAME keyword"
  /// What the scene report says under "modelled"; empty: it is off.
  std::string (*report)(const Script& script);
};

/// All models there are.
const std::vector<Model>& models();

/// What follows the word model: a name, then keywords of that model with their values.
void parse_model(const Line& line);

}  // namespace twogrid
