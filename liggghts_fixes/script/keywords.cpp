#include "liggghts_fixes/script/keywords.h"

#include <algorithm>
#include <cctype>

#include "coupling/methods.h"

namespace twogrid {
namespace {

std::string value_or_default(const Keyword& row, const Script& script) {
  const std::string value = row.value(script);
  return value.empty() ? default_text(row) : value;
}

std::string table(const std::vector<Keyword>& rows) {
  std::string s = "| keyword | values | default |\n|---|---|---|\n";
  for (const Keyword& k : rows) {
    const std::string standard = default_text(k);
    const bool word = k.standard.empty() && std::isalpha(static_cast<unsigned char>(standard[0]));  // of a script
    s += "| `" + k.words + "` | " + k.values + (k.unit.empty() ? "" : ", " + k.unit) +
         (k.text.empty() ? "" : ": " + k.text) + " | " + (word ? "`" + standard + "`" : standard) + " |\n";
  }
  return s;
}

/// The first word that this keyword of fix_modify has.
std::string word_of(const std::string& keyword, const Script& script) {
  const std::vector<Keyword>& rows = fix_modify_keywords();
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const Keyword& k) { return k.words == keyword; });
  const std::string value = row->value(script);
  return value.substr(0, value.find(' '));
}

std::string methods_table() {
  std::string s = "| method | deposit | prolong | read | what it is |\n|---|---|---|---|---|\n";
  for (const std::string& name : split(method_names())) {
    const Method& m = *find_method(name);
    Script script;
    choose(m, 0, script.settings);
    s += "| `" + name + "` | `" + word_of("deposit", script) + "` | `" + word_of("prolong", script) + "` | `" +
         word_of("read", script) + "` | " + m.reference + " |\n";
  }
  return s;
}

}  // namespace

const Keyword* take_keyword(const std::vector<Keyword>& rows, Words& words) {
  const std::string first = words.peek();
  std::vector<std::string> seconds;
  std::vector<const Keyword*> found;
  for (const Keyword& k : rows) {
    if (k.words == first) {
      words.word("", "");
      return &k;
    }
    if (k.words.rfind(first + " ", 0) == 0) {
      seconds.push_back(k.words.substr(first.size() + 1));
      found.push_back(&k);
    }
  }
  if (found.empty()) return nullptr;
  words.word("", "");
  return found[words.one_of(first, seconds)];
}

void take_values(const Keyword& row, Script& script, Words& words, bool started) {
  if (started && !row.later)
    refuse(row.words, "a change after the first run",
           "it before: only velocities of inlets and walls and the times of output and means may change later");
  row.parse(Line{script, words, row.words, started});
}

std::string listed(const std::vector<Keyword>& rows) {
  std::vector<std::string> words;
  for (const Keyword& k : rows) words.push_back(k.words);
  return listed(words);
}

std::string default_text(const Keyword& row) {
  return row.standard.empty() ? row.value(Script()) : row.standard;
}

std::vector<std::pair<std::string, std::string>> settings_texts(const Script& script) {
  std::vector<std::pair<std::string, std::string>> texts;
  for (const auto* rows : {&fix_keywords(), &fix_modify_keywords()})
    for (const Keyword& k : *rows)
      if (k.value) texts.emplace_back(k.words, value_or_default(k, script));
  return texts;
}

std::string report_line(const std::string& line, const Script& script, bool changed_only) {
  std::string s;
  for (const Keyword& k : fix_modify_keywords()) {
    if (k.line != line) continue;
    const std::string value = k.value(script), note = k.note ? k.note(script) : "";
    if (value.empty() || (changed_only && value == k.value(Script()))) continue;
    s += (s.empty() ? "" : ", ") + k.words + " " + value + (note.empty() ? "" : " (" + note + ")");
  }
  return s;
}

std::string keyword_page() {
  return "`fix ID group twogrid keyword values ...`\n\n" + table(fix_keywords()) +
         "\n`fix_modify ID keyword values ...`; several may follow each other on a line\n\n" +
         table(fix_modify_keywords()) + "\n" + methods_table();
}

}  // namespace twogrid
