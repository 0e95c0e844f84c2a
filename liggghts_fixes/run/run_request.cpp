#include "liggghts_fixes/run/run_request.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace twogrid {

namespace {

constexpr long long kMostSteps = 9000000000000000;

std::optional<long long> whole(const std::string& word) {
  char* end = nullptr;
  const long long n = std::strtoll(word.c_str(), &end, 10);
  if (word.empty() || *end != '\0' || n < -kMostSteps || n > kMostSteps) return std::nullopt;
  return n;
}

}  // namespace

long long RunRequest::part_begin(long long step) const {
  return every > 0 ? begin + (step - begin) / every * every : begin;
}

long long RunRequest::part_end(long long step) const {
  return every > 0 ? std::min(end, part_begin(step) + every) : end;
}

std::vector<std::string> RunRequest::words(long long step, long long to, bool set_up) const {
  const long long from = part_begin(step), until = part_end(step);
  std::vector<std::string> w{std::to_string(to - step)};
  if (start || from != step || to != until) w.insert(w.end(), {"start", std::to_string(start.value_or(from))});
  if (stop || to != until || from != step) w.insert(w.end(), {"stop", std::to_string(stop.value_or(until))});
  if (!set_up) w.insert(w.end(), {"pre", "no"});
  // As LIGGGHTS: between parts as it was asked for, after the last one always.
  if (to != until || (!post && (every == 0 || to != end))) w.insert(w.end(), {"post", "no"});
  return w;
}

std::optional<RunRequest> run_request(const std::vector<std::string>& words, long long step, double dt) {
  if (words.size() < 2 || step < 0 || step > kMostSteps) return std::nullopt;
  RunRequest r;
  std::optional<long long> n = whole(words[1]);
  if (words[0] == "run_time") {
    char* end = nullptr;
    const double t = std::strtod(words[1].c_str(), &end);
    if (*end != '\0' || !(t >= 0) || !(dt > 0) || !(t / dt < double(kMostSteps))) return std::nullopt;
    n = (long long)(std::ceil(t / dt));
    // LIGGGHTS takes no steps for a rule here: with none it reads the time as a number of them.
    if (*n == 0) return std::nullopt;
  }
  if (!n) return std::nullopt;
  bool upto = false;
  const auto yes_or_no = [&](std::size_t i, bool& flag) {
    if (i >= words.size() || (words[i] != "yes" && words[i] != "no")) return false;
    flag = words[i] == "yes";
    return true;
  };
  for (std::size_t i = 2; i < words.size();) {
    const std::string& w = words[i];
    if (w == "upto") {
      upto = true, i += 1;
    } else if (w == "start" || w == "stop") {
      const std::optional<long long> at = i + 1 < words.size() ? whole(words[i + 1]) : std::nullopt;
      if (!at) return std::nullopt;
      (w == "start" ? r.start : r.stop) = at, i += 2;
    } else if (w == "pre" || w == "post") {
      if (!yes_or_no(i + 1, w == "pre" ? r.pre : r.post)) return std::nullopt;
      i += 2;
    } else if (w == "every") {
      const std::optional<long long> m = i + 2 < words.size() ? whole(words[i + 1]) : std::nullopt;
      if (!m || *m <= 0) return std::nullopt;
      r.every = *m;
      r.commands.assign(words.begin() + std::ptrdiff_t(i) + 2, words.end());
      if (r.commands.size() == 1 && r.commands[0] == "NULL") r.commands.clear();
      i = words.size();
    } else {
      return std::nullopt;
    }
  }
  r.begin = step;
  r.end = upto ? *n : step + *n;
  if (r.end < step || r.end - step > std::numeric_limits<int>::max()) return std::nullopt;
  if (r.start && (*r.start < 0 || *r.start > step)) return std::nullopt;
  if (r.stop && *r.stop < r.end) return std::nullopt;
  return r;
}

}  // namespace twogrid
