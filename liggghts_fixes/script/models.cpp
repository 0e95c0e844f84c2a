#include "liggghts_fixes/script/models.h"

namespace twogrid {

Model gap_friction();

const std::vector<Model>& models() {
  static const std::vector<Model> kModels{gap_friction()};
  return kModels;
}

void install_models(const ModelSite& site) {
  for (const Model& m : models())
    if (m.install && !m.report(site.script).empty()) m.install(site);
}

void parse_model(const Line& line) {
  std::vector<std::string> names;
  for (const Model& m : models()) names.push_back(m.name);
  const std::string name = line.words.word("model", listed(names));
  for (const Model& m : models()) {
    if (m.name != name) continue;
    std::vector<Keyword> rows = m.keywords;
    for (Keyword& k : rows) k.words = k.words.substr(name.size() + 1);
    bool any = false;
    for (const Keyword* row; (row = take_keyword(rows, line.words)); any = true) {
      const std::string whole = "model " + name + " " + row->words;
      Keyword named = *row;
      named.words = whole;
      take_values(named, line.script, line.words, line.started);
    }
    if (!any) refuse("model " + name, line.words.peek(), listed(rows));
    return;
  }
  refuse("model", "'" + name + "', which is no model", "one of those there are: " + listed(names));
}

}  // namespace twogrid
