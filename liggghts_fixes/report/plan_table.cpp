#include "liggghts_fixes/report/plan_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "liggghts_fixes/report/memory_need.h"
#include "liggghts_fixes/report/progress.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

namespace {

std::string left(const std::string& s, std::size_t width) {
  return s + std::string(s.size() < width ? width - s.size() : 0, ' ');
}

std::string right(const std::string& s, std::size_t width) {
  return std::string(s.size() < width ? width - s.size() : 0, ' ') + s;
}

std::string percent(double part, double whole) {
  char text[32];
  const double p = whole > 0 ? 100 * part / whole : 0.0;
  std::snprintf(text, sizeof text, p < 9.95 ? "%.1f %%" : "%.0f %%", p);
  return text;
}

std::string count(double n) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f", n);
  return text;
}

std::string short_line(const std::string& line) {
  constexpr std::size_t kMost = 36;
  return line.size() > kMost ? line.substr(0, kMost - 3) + "..." : line;
}

}  // namespace

std::string planned_time(double s) {
  if (s < 99.95) {
    char text[32];
    std::snprintf(text, sizeof text, s < 9.95 ? "%.2g s" : "%.0f s", s);
    return text;
  }
  if (s < 48 * 3600.0) return duration(s);
  char text[32];
  std::snprintf(text, sizeof text, "%.0f days", s / 86400);
  return text;
}

double plan_seconds(const Plan& plan, int ranks) {
  double sum = plan.setup_seconds;
  for (const PlannedRun& r : plan.runs) sum += seconds_on(r, ranks);
  return sum;
}

std::string plan_text(const Plan& plan) {
  std::string out =
      "twogrid: the plan of " + plan.script + ": each run was cut short and measured; nothing is written\n";
  const double all = plan_seconds(plan, plan.ranks);
  constexpr std::size_t kMany = 30;
  out += "  " + left("run", 42) + right("steps", 12) + right("particles", 12) + right("fluid steps", 13) +
         right("time", 14) + right("share", 9) + "\n";
  double steps = 0, most_particles = 0;
  std::size_t dearest = 0;
  bool at_most = false;
  for (std::size_t i = 0; i < plan.runs.size(); ++i) {
    const PlannedRun& r = plan.runs[i];
    const double t = seconds_on(r, plan.ranks);
    steps += double(r.steps), most_particles = std::max(most_particles, r.particles);
    at_most = at_most || r.at_most;
    if (t > seconds_on(plan.runs[dearest], plan.ranks)) dearest = i;
    if (i >= kMany) continue;
    out += "  " + left(right(std::to_string(i + 1), 3) + "  " + short_line(r.line), 42) +
           right((r.at_most ? "at most " : "") + std::to_string(r.steps), 12) + right(count(r.particles), 12) +
           right(r.couplings > 0 ? count(r.fluid_steps) : "-", 13) + right(planned_time(t), 14) +
           right(percent(t, all), 9) + "\n";
  }
  if (plan.runs.size() > kMany) out += "  ... and " + std::to_string(plan.runs.size() - kMany) + " more\n";
  if (plan.runs.empty()) {
    out += "  no run\n";
  } else {
    out += "  " + left("all", 42) + right(count(steps), 12) + right(count(most_particles), 12) + right("", 13) +
           right(planned_time(all), 14) + "\n";
    if (plan.runs.size() > 1)
      out += "  most of the time: run " + std::to_string(dearest + 1) + ", " + short_line(plan.runs[dearest].line) +
             ", " + percent(seconds_on(plan.runs[dearest], plan.ranks), all) + "\n";
  }
  out += "  time                  " + std::string(at_most ? "at most " : "about ") + planned_time(all) + " on " +
         std::to_string(plan.ranks) + (plan.ranks == 1 ? " rank" : " ranks") +
         ", as now, if each has a core of this machine for itself; between 1/1.5 and 1.5 times that\n";
  out += "  memory                " + bytes_text(plan.most_bytes) + " a rank on " + std::to_string(plan.ranks) + "\n";

  double bytes = 0;
  for (const PlannedFile& f : plan.files) bytes += f.bytes;
  out += "  files                 " + bytes_text(bytes) + " in all\n";
  constexpr std::size_t kFiles = 12;
  for (std::size_t i = 0; i < plan.files.size() && i < kFiles; ++i) {
    const PlannedFile& f = plan.files[i];
    out +=
        "    " + left(f.name, 40) + " " + right(bytes_text(f.bytes), 9) + (f.what.empty() ? "" : "  " + f.what) + "\n";
  }
  if (plan.files.size() > kFiles) out += "    ... and " + std::to_string(plan.files.size() - kFiles) + " more\n";

  if (!plan.runs.empty()) {
    out +=
        "  on other numbers of ranks, by a model of messages and halos within one machine (* not with this script's "
        "processors):\n";
    out += "  " + right("ranks", 8) + right("time", 14) + right("speed-up", 11) + right("a rank's memory", 18) + "\n";
    const double one = plan_seconds(plan, 1);
    const PlannedRun& main = plan.runs[dearest];
    std::vector<int> numbers;
    for (int n = 1; n <= 1024; n *= 2) numbers.push_back(n);
    if (std::find(numbers.begin(), numbers.end(), plan.ranks) == numbers.end()) numbers.push_back(plan.ranks);
    std::sort(numbers.begin(), numbers.end());
    double before = 1e300;
    for (int n : numbers) {
      const double t = plan_seconds(plan, n);
      if (n > plan.ranks && n > 8 && t > 0.9 * before) break;  // more don't help
      before = t;
      char speed[32];
      std::snprintf(speed, sizeof speed, "%.3g", one / std::max(t, 1e-9));
      out += "  " + right((script_allows(main.parts, n) ? "" : "*") + std::to_string(n), 8) +
             right(planned_time(t), 14) + right(speed, 11) +
             right(bytes_text(bytes_on(main.parts, plan.empty_bytes, plan.most_bytes, n)), 18) +
             (n == plan.ranks ? "  measured" : "") + "\n";
    }
  }
  for (const std::string& r : plan.remarks) out += "  " + r + "\n";
  return out;
}

}  // namespace twogrid
