// Models: parts of the physics that a script switches on, `fix_modify ID model NAME keyword value ...`. A model's
// equations, its state and its step stand in a file of its own in cfd/ (FluidModel) or coupling/ (ExchangeModel), with
// its numbers as a member of FluidSettings or Settings; what a script and a report say of it, and how it is made, in a
// file of its own in models/. To add one: those two files, that member, its line in models.cpp, and README.md beside it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "liggghts_fixes/script/keywords.h"

namespace twogrid {

class Coupling;
class FluidSolver;

/// Where a model comes in.
struct ModelSite {
  const Script& script;
  FluidSolver& fluid;
  Coupling& coupling;
  /// Values a particle of `fix property/atom` of this name and one column, as they lie now; null: there is none.
  std::function<double*(const std::string& name)> particle_property;
};

struct Model {
  std::string name;               ///< first word of all its keywords
  std::vector<Keyword> keywords;  ///< its rows: words "NAME keyword"
  /// What the scene report says under "modelled"; empty: it is off.
  std::string (*report)(const Script& script);
  /// Adds it to fluid and coupling when they have been made, if the script has switched it on; null: nothing to add.
  void (*install)(const ModelSite& site) = nullptr;
  /// Fields of the fluid's cells that it keeps (FluidSolver::add_field()), which `output fields` may name.
  std::vector<std::string> fields = {};
  /// Of the effects that the report lists as not modelled, that which it models; empty: none of them.
  std::string effect = {};
};

/// All models there are.
const std::vector<Model>& models();

/// Installs those that are on. Collective.
void install_models(const ModelSite& site);

/// What follows the word model: a name, then keywords of that model with their values.
void parse_model(const Line& line);

}  // namespace twogrid
