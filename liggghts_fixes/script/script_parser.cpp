#include "liggghts_fixes/script/script_parser.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "liggghts_fixes/script/keywords.h"

namespace twogrid {

Script parse_fix(const std::string& id, const std::vector<std::string>& all) {
  Script script;
  Settings& s = script.settings;
  s.id = id;
  Words words(all);
  std::set<std::string> seen;
  while (!words.end()) {
    const Keyword* row = take_keyword(fix_keywords(), words);
    if (!row)
      throw std::invalid_argument("unknown keyword '" + shown(words.peek()) + "' in fix twogrid, wanted " +
                                  listed(fix_keywords()));
    if (!seen.insert(row->words).second && !row->parts) refuse(row->words, "it twice", "it once");
    take_values(*row, script, words, false);
  }
  for (const Keyword& row : fix_keywords())
    if (row.standard == kRequired && !seen.count(row.words)) {
      std::string wanted = row.words + " " + row.values + (row.unit.empty() ? "" : " in " + row.unit);
      wanted.erase(std::remove(wanted.begin(), wanted.end(), '`'), wanted.end());
      refuse(row.words, "no such keyword in the fix command", wanted);
    }
  for (int d = 0; d < 3; ++d) {
    if (script.fine_auto[d] && !seen.count("ratio")) script.ratio_auto[d] = true, s.ratio[d] = 0;
    if (script.fine_auto[d] && s.stretch[d] != 1)
      refuse("fine", "auto together with stretch in " + std::string(1, "xyz"[d]),
             "a number of fine cells there (auto chooses equal cells), and auto elsewhere");
    if (script.fine_auto[d] || script.ratio_auto[d]) continue;
    if (s.fine[d] % s.ratio[d] != 0)
      refuse("ratio", text(s.ratio[d]) + " in " + "xyz"[d] + " for fine " + text(s.fine[d]),
             "a ratio that divides the number of fine cells: " + text(s.fine[d]) + " is no multiple of " +
                 text(s.ratio[d]));
  }
  return script;
}

void parse_fix_modify(Script& script, const std::vector<std::string>& all, bool started) {
  if (all.empty()) refuse("fix_modify", "no keyword", listed(fix_modify_keywords()));
  Script changed = script;  // a line that is wrong changes nothing
  Words words(all);
  while (!words.end()) {
    const Keyword* row = take_keyword(fix_modify_keywords(), words);
    if (!row)
      throw std::invalid_argument("unknown keyword '" + shown(words.peek()) + "' in fix_modify, wanted " +
                                  listed(fix_modify_keywords()));
    take_values(*row, changed, words, started);
  }
  script = std::move(changed);
}

}  // namespace twogrid
