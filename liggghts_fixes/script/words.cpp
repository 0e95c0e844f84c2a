#include "liggghts_fixes/script/words.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

namespace twogrid {

namespace {

bool is_control(char c) {
  return (c >= 0 && c < ' ') || c == 127;
}

}  // namespace

std::string shown(std::string word) {
  constexpr std::size_t kMost = 500;
  for (char& c : word)
    if (is_control(c)) c = '?';
  if (word.size() <= kMost) return word;
  return word.substr(0, kMost / 2) + "... (" + std::to_string(word.size()) + " characters)";
}

void refuse(const std::string& keyword, const std::string& found, const std::string& wanted) {
  throw std::invalid_argument(shown(keyword) + ": found " + (found.empty() ? "nothing" : shown(found)) + ", wanted " +
                              wanted);
}

std::string text(double value) {
  std::ostringstream out;
  out.precision(6);
  out << value;
  if (std::strtod(out.str().c_str(), nullptr) == value) return out.str();
  out.str("");
  out.precision(12);
  out << value;
  return out.str();
}

std::string exact(double value) {
  std::ostringstream out;
  for (int digits : {6, 12, 15, 16, 17}) {
    out.str("");
    out.precision(digits);
    out << value;
    if (std::strtod(out.str().c_str(), nullptr) == value) break;
  }
  return out.str();
}

std::string brief(double value) {
  std::ostringstream out;
  out.precision(4);
  out << value;
  return out.str();
}

bool is_name(const std::string& name) {
  constexpr std::size_t kMost = 255, kMostPath = 4095;
  if (name.empty() || name.size() > kMostPath || std::any_of(name.begin(), name.end(), is_control)) return false;
  if (std::isspace(static_cast<unsigned char>(name.front())) || std::isspace(static_cast<unsigned char>(name.back())))
    return false;
  std::size_t begin = 0, end = 0;
  for (; end != std::string::npos; begin = end + 1) {
    end = name.find('/', begin);
    if (std::min(end, name.size()) - begin > kMost) return false;
  }
  return true;
}

bool is_number(const std::string& word, double* value) {
  if (word.empty() || std::isspace(static_cast<unsigned char>(word[0]))) return false;
  char* end = nullptr;
  *value = std::strtod(word.c_str(), &end);
  return end == word.c_str() + word.size() && std::isfinite(*value);
}

std::vector<std::string> split(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string w; in >> w;) words.push_back(w);
  return words;
}

std::string listed(const std::vector<std::string>& words) {
  std::string s;
  for (std::size_t i = 0; i < words.size(); ++i) s += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return s;
}

const std::string& Words::peek() const {
  static const std::string kNone;
  return end() ? kNone : words_[next_];
}

bool Words::take_if(const std::string& word) {
  if (!next_is(word)) return false;
  ++next_;
  return true;
}

std::string Words::word(const std::string& keyword, const std::string& wanted) {
  if (end()) refuse(keyword, "the end of the line", wanted);
  return words_[next_++];
}

std::string Words::name(const std::string& keyword, const std::string& wanted) {
  std::string w = word(keyword, wanted);
  if (!is_name(w)) refuse(keyword, "'" + shown(w) + "'", wanted + ", of at most 255 characters that can be printed");
  return w;
}

double Words::number(const std::string& keyword, const std::string& wanted, const Range& range) {
  const std::string w = word(keyword, wanted);
  double value = 0;
  if (w.rfind("v_", 0) == 0)
    refuse(keyword, w,
           wanted + " (a variable's value is written ${" + w.substr(2) + "} here; v_ follows time only in velocities)");
  if (!is_number(w, &value)) refuse(keyword, w, wanted);
  if (!(value >= range.least && value <= range.most))
    refuse(keyword, w, wanted + "; " + text(range.least) + " to " + text(range.most));
  return value;
}

int Words::whole(const std::string& keyword, const std::string& wanted, int smallest) {
  const std::string found = peek();
  const double value = number(keyword, wanted, {-HUGE_VAL, HUGE_VAL});
  if (value != std::floor(value) || value < smallest || value > 2e9) refuse(keyword, found, wanted);
  return int(value);
}

int Words::one_of(const std::string& keyword, const std::vector<std::string>& allowed) {
  const std::string w = word(keyword, listed(allowed));
  for (std::size_t i = 0; i < allowed.size(); ++i)
    if (w == allowed[i]) return int(i);
  refuse(keyword, w, listed(allowed));
}

}  // namespace twogrid
