// Friction of two walls on the flow between them, where one cell spans the gap: -12 mu u/W^2, that of the parabola
// between plates a distance W apart. Its step: cfd/fluid/predictor.cpp.
#include "liggghts_fixes/script/models.h"
#include "liggghts_fixes/script/options.h"

namespace twogrid {
namespace {

const Options<bool>& switches() {
  static const Options<bool> kSwitches{{false, "off"}, {true, "on"}};
  return kSwitches;
}

}  // namespace

Model gap_friction() {
  return {
      "gap",
      {{"gap friction", option_list(switches()), "", "friction of two walls in a direction with one cell, -12 mu u/W^2",
        "", "", [](const Line& l) { l.fluid().gap_friction = take_option(l.words, l.keyword, switches()); },
        [](const Script& s) { return std::string(option_of(switches(), s.settings.fluid.gap_friction).word); }}},
      [](const Script& s) { return std::string(s.settings.fluid.gap_friction ? "gap friction" : ""); }};
}

}  // namespace twogrid
