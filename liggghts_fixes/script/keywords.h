// The table of keywords. All that is known of a keyword stands in its row: the parser, the scene report, the record in
// the output file and `twogrid -keywords` read it there, and by the tables of README.md beside it, which a test holds against it,
// cases/sweep.py. Rows: fix_keywords.cpp, fix_modify_keywords.cpp, and those of models in models/.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "liggghts_fixes/script/script.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

/// What a row's parser works on: the words after its keyword, and where they go.
struct Line {
  Script& script;
  Words& words;
  const std::string& keyword;  ///< for the sentences
  bool started;                ///< a run has taken place

  Settings& settings() const { return script.settings; }
  FluidSettings& fluid() const { return script.settings.fluid; }
  double number(const std::string& wanted, const Range& range) const { return words.number(keyword, wanted, range); }
};

/// Default of keywords that must be given.
constexpr char kRequired[] = "required";

struct Keyword {
  std::string words;     ///< one or two, as the script has them
  std::string values;    ///< what follows: `word` as it stands, anything else in place of a value
  std::string unit;      ///< of the values; empty: none, or told in values
  std::string text;      ///< what it is, one line
  std::string standard;  ///< what holds where a script doesn't say it; empty: what value() tells of an empty script
  std::string line;      ///< of the scene report, that shows it; empty: the report has words of its own for it
  std::function<void(const Line&)> parse;           ///< throws std::invalid_argument with a sentence
  std::function<std::string(const Script&)> value;  ///< what a script would have after the keyword; empty: not set
  /// What the value is, where the word alone doesn't tell; may be null.
  std::function<std::string(const Script&)> note = {};
  bool parts = false;  ///< given once for each direction or side; value() joins them with "; "
  bool later = false;  ///< may change after the first run, in part: parse() refuses the rest
};

/// Rows of `fix ID group twogrid`, in the order of the reference page.
const std::vector<Keyword>& fix_keywords();
/// Rows of `fix_modify ID`, those of models last.
const std::vector<Keyword>& fix_modify_keywords();

/// Takes the word or words of a row, and gives it; null, and nothing taken, if the next word begins none.
const Keyword* take_keyword(const std::vector<Keyword>& rows, Words& words);
/// Takes what follows the words of a row of fix_modify.
void take_values(const Keyword& row, Script& script, Words& words, bool started);
/// "fine, ratio or every": all words of these rows.
std::string listed(const std::vector<Keyword>& rows);

/// The default in words.
std::string default_text(const Keyword& row);
/// All settings: keyword, and what a script would have after it, or what holds instead.
std::vector<std::pair<std::string, std::string>> settings_texts(const Script& script);
/// "deposit trilinear, prolong constant": the keywords that this line of the scene report shows. changed_only: without
/// those that have their default.
std::string report_line(const std::string& line, const Script& script, bool changed_only = false);

/// The reference page: tables of both commands' keywords and of the methods (Markdown).
std::string keyword_page();

}  // namespace twogrid
