#include "tests/fuzz/fuzz.h"

#include <algorithm>
#include <cstdlib>

namespace twogrid_fuzz {

const std::vector<std::string>& odd_words() {
  static const std::vector<std::string> kWords{"0",
                                               "-1",
                                               "-0",
                                               "1",
                                               "2",
                                               "0.5",
                                               "1e-3",
                                               "nan",
                                               "-nan",
                                               "NAN(1)",
                                               "inf",
                                               "-inf",
                                               "infinity",
                                               "1e308",
                                               "-1e308",
                                               "1e309",
                                               "1e-308",
                                               "5e-324",
                                               "2147483647",
                                               "2147483648",
                                               "-2147483649",
                                               "4294967296",
                                               "9e18",
                                               "9223372036854775807",
                                               "9223372036854775808",
                                               "1e15",
                                               "1e6",
                                               "1e-12",
                                               "0x7fffffff",
                                               "0x1p1023",
                                               "1e",
                                               "1.8e-5x",
                                               "",
                                               " ",
                                               " 1",
                                               "1 ",
                                               "\t",
                                               "\n",
                                               "'",
                                               "\"",
                                               "\"a b\"",
                                               "\\",
                                               "v_x",
                                               "v_",
                                               "v_v_x",
                                               "$x",
                                               "${x}",
                                               "NULL",
                                               "off",
                                               "on",
                                               "auto",
                                               "yes",
                                               "no",
                                               "every",
                                               "\xc3\xa9t\xc3\xa9",
                                               "\xff\xfe",
                                               "\x01\x02\x7f",
                                               "%s%s%n",
                                               "../../x",
                                               "/dev/zero",
                                               "/dev/null",
                                               "/",
                                               ".",
                                               std::string(300, 'a'),
                                               std::string(70000, '9'),
                                               std::string(5000, '/'),
                                               "1," + std::string(400, '0')};
  return kWords;
}

namespace {

bool is_numeric(const std::string& w) {
  char* end = nullptr;
  std::strtod(w.c_str(), &end);
  return !w.empty() && *end == '\0';
}

std::string other_number(const std::string& w, Dice& dice) {
  static const std::vector<std::string> kFactors{"-1",   "0",     "1e3",    "1e-3",   "1e9", "1e-9",
                                                 "1e30", "1e300", "1e-300", "1.0001", "0.5"};
  return std::to_string(std::strtod(w.c_str(), nullptr) * std::strtod(dice.of(kFactors).c_str(), nullptr));
}

std::size_t number_place(const std::vector<std::string>& words, Dice& dice) {
  const std::size_t from = dice.below(words.size());
  for (std::size_t i = 0; i < words.size(); ++i)
    if (is_numeric(words[(from + i) % words.size()])) return (from + i) % words.size();
  return from;
}

}  // namespace

void mutate(std::vector<std::string>& words, Dice& dice, const std::vector<std::vector<std::string>>& others) {
  if (words.empty()) words.push_back(dice.of(odd_words()));
  const std::size_t i = dice.below(words.size());
  const auto at = [&](std::size_t n) { return words.begin() + std::ptrdiff_t(n); };
  switch (dice.below(12)) {
    case 0:
      words.erase(at(i));
      break;
    case 1:
      words.insert(at(i), std::string(words[i]));
      break;
    case 2:
      std::swap(words[i], words[dice.below(words.size())]);
      break;
    case 3:
      words.insert(at(i), dice.of(odd_words()));
      break;
    case 4:
      words[i] = dice.of(odd_words());
      break;
    case 5:
      words.resize(i);
      break;
    case 6: {
      const std::vector<std::string>& other = dice.of(others);
      const std::size_t from = dice.below(other.size());
      words.insert(at(i), other.begin() + std::ptrdiff_t(from), other.end());
      break;
    }
    case 7:
      mutate_bytes(words[i], dice);
      std::replace(words[i].begin(), words[i].end(), '\0', '0');  // words are C strings
      break;
    case 8: {
      const std::size_t n = number_place(words, dice);
      words[n] = other_number(words[n], dice);
      break;
    }
    case 9: {  // a part of it many times
      const std::vector<std::string> part(at(i), at(std::min(i + 3, words.size())));
      for (std::size_t k = dice.below(dice.one_in(50) ? 3000 : 5); k > 0; --k)
        words.insert(at(i), part.begin(), part.end());
      break;
    }
    default:
      words[number_place(words, dice)] = dice.of(odd_words());
  }
}

void mutate_bytes(std::string& bytes, Dice& dice) {
  if (bytes.empty()) return;
  const std::size_t at = dice.below(bytes.size());
  const std::size_t most = std::min<std::size_t>(bytes.size() - at, 1 + dice.below(dice.one_in(4) ? 4096 : 32));
  switch (dice.below(7)) {
    case 0:
    case 1:
      bytes[at] = char(bytes[at] ^ (1 << dice.below(8)));
      break;
    case 2:
      bytes.resize(at);
      break;
    case 3:
      std::fill_n(bytes.begin() + std::ptrdiff_t(at), most, '\0');
      break;
    case 4:
      bytes.insert(at, bytes.substr(dice.below(bytes.size()), most));
      break;
    case 5:
      for (std::size_t k = 0, from = dice.below(bytes.size() - most + 1); k < most; ++k)
        std::swap(bytes[at + k], bytes[from + k]);
      break;
    default:
      for (std::size_t k = 0; k < most; ++k) bytes[at + k] = char(dice.below(256));
  }
}

void mutate_text(std::string& text, Dice& dice) {
  std::vector<std::string> lines{""};
  for (char c : text) {
    if (c == '\n')
      lines.emplace_back();
    else
      lines.back() += c;
  }
  const std::size_t i = dice.below(lines.size());
  switch (dice.below(5)) {
    case 0:
      lines.erase(lines.begin() + std::ptrdiff_t(i));
      break;
    case 1:
      lines.insert(lines.begin() + std::ptrdiff_t(i), std::string(lines[i]));
      break;
    case 2:
      std::swap(lines[i], lines[dice.below(lines.size())]);
      break;
    case 3:
      mutate_bytes(text, dice);
      return;
    default: {
      std::vector<std::string> words{""};
      for (char c : lines[i]) {
        if (c == ' ')
          words.emplace_back();
        else
          words.back() += c;
      }
      words[number_place(words, dice)] = dice.of(odd_words());
      lines[i] = joined(words);
    }
  }
  text.clear();
  for (std::size_t k = 0; k < lines.size(); ++k) text += (k ? "\n" : "") + lines[k];
}

std::string joined(const std::vector<std::string>& words) {
  std::string s;
  for (const std::string& w : words) s += (s.empty() ? "" : " ") + w;
  return s;
}

Verdict tried(const std::function<void()>& f, const std::vector<std::string>& words) {
  Verdict v;
  const auto sentence = [&](const std::string& s) {
    const bool names = std::any_of(words.begin(), words.end(), [&](const std::string& w) {
      return w.size() > 2 && s.find(w) != std::string::npos;
    });
    if (s.size() < 15 || s.find(' ') == std::string::npos ||
        (s.find("wanted") == std::string::npos && s.find("fix_modify ") == std::string::npos && !names))
      v.defect = "refused without a sentence: '" + s + "'";
    else if (s.size() > 6000 || s.find('\n') != std::string::npos)
      v.defect = "refused with a sentence of more than a line: '" + s.substr(0, 300) + "'";
  };
  try {
    f();
    v.accepted = true;
  } catch (const std::invalid_argument& e) {
    sentence(e.what());
  } catch (const std::runtime_error& e) {
    sentence(e.what());
  } catch (const std::exception& e) {
    v.defect = std::string("ended by ") + e.what();
  }
  return v;
}

std::string outside(const std::vector<Bound>& bounds) {
  for (const Bound& b : bounds)
    if (!(b.value >= b.least && b.value <= b.most)) return "accepted " + b.what + " = " + std::to_string(b.value);
  return "";
}

}  // namespace twogrid_fuzz
