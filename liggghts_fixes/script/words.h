// The words of one command, read from the left.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "liggghts_fixes/script/limits.h"

namespace twogrid {

/// "KEYWORD: found FOUND, wanted WANTED". Throws std::invalid_argument.
[[noreturn]] void refuse(const std::string& keyword, const std::string& found, const std::string& wanted);

/// What a sentence shows of a word that may be anything: one line, the beginning of what is very long.
std::string shown(std::string word);

/// Shortest decimal text of a number that a user would recognise.
std::string text(double value);
/// Shortest decimal text that is read back as the same number.
std::string exact(double value);
/// Four significant digits: for what a user reads, not for what a program reads.
std::string brief(double value);

class Words {
 public:
  explicit Words(const std::vector<std::string>& words) : words_(words) {}

  bool end() const { return next_ == words_.size(); }
  /// The next word, or "" at the end. Stays there.
  const std::string& peek() const;
  bool next_is(const std::string& word) const { return !end() && words_[next_] == word; }
  bool take_if(const std::string& word);

  /// Each takes the next word; keyword and wanted go into the sentence if it is missing or wrong.
  std::string word(const std::string& keyword, const std::string& wanted);
  /// Of a file, a variable, a patch ...: not empty, no control characters or blanks around it, at most 255 bytes between slashes.
  std::string name(const std::string& keyword, const std::string& wanted);
  /// A number of a quantity: from the least of the range to the most.
  double number(const std::string& keyword, const std::string& wanted, const Range& range);
  int whole(const std::string& keyword, const std::string& wanted, int smallest);
  /// Index of the next word in the list of those allowed.
  int one_of(const std::string& keyword, const std::vector<std::string>& allowed);
  bool yes_or_no(const std::string& keyword) { return one_of(keyword, {"no", "yes"}) == 1; }

 private:
  const std::vector<std::string>& words_;
  std::size_t next_ = 0;
};

/// The whole word as a finite number.
bool is_number(const std::string& word, double* value);
/// Whether a name could be one, see Words::name.
bool is_name(const std::string& name);
/// The words of a text, which blanks part.
std::vector<std::string> split(const std::string& text);
/// "a, b or c".
std::string listed(const std::vector<std::string>& words);

}  // namespace twogrid
