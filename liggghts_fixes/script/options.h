// Words that stand for the values of an enum (or of a bool): one list for the parser, the scene report, the record and
// the reference page, so that the order of an enum means nothing.
#pragma once

#include <string>
#include <vector>

#include "liggghts_fixes/script/words.h"

namespace twogrid {

template <class E>
struct Option {
  E value;
  const char* word;
  const char* note = "";   ///< what it is, where the word alone doesn't tell
  const char* takes = "";  ///< the length (m) that follows the word
};
template <class E>
using Options = std::vector<Option<E>>;

/// Takes the next word.
template <class E>
E take_option(Words& words, const std::string& keyword, const Options<E>& options) {
  std::vector<std::string> allowed;
  for (const Option<E>& o : options) allowed.push_back(o.word);
  return options[words.one_of(keyword, allowed)].value;
}

template <class E>
const Option<E>& option_of(const Options<E>& options, E value) {
  for (const Option<E>& o : options)
    if (o.value == value) return o;
  return options.front();
}

/// "`cell` (mean of the particle cell), `kernel` WIDTH (m, on the fine grid)", of the reference page.
template <class E>
std::string option_list(const Options<E>& options) {
  std::string list;
  for (const Option<E>& o : options) {
    list += (list.empty() ? "`" : ", `") + std::string(o.word) + "`";
    const std::string unit = *o.takes ? "m" : "", comma = *o.takes && *o.note ? ", " : "";
    if (*o.takes) list += std::string(" ") + o.takes;
    if (*o.takes || *o.note) list += " (" + unit + comma + o.note + ")";
  }
  return list;
}

}  // namespace twogrid
