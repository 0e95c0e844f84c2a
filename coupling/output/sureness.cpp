#include "coupling/output/sureness.h"

#include <algorithm>
#include <cstdio>

#include "coupling/output/averages.h"

namespace twogrid {

namespace {

std::string percent(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g %%", 100 * x);
  return text;
}

/// What 'until' lacks, of errors that are known.
std::string missing(const MeansError& e, double weight, double until, const std::string& of_one) {
  if (e.trusted()) {
    const double worst = std::max(e.eps, e.flux) / until;
    return percent(until) + (worst > 1 ? ", which takes some " + seconds(weight * (worst * worst - 1)) + " more" : "");
  }
  return percent(until) + ": a longer run, whose batches are " +
         (e.long_enough() ? "less alike" : "longer than four correlation times") +
         ", or one in which a single batch scatters by " + percent(until / MeansError::kDriftOver) + " at most (now " +
         percent(e.scatter) + ")" + (of_one.empty() ? "" : " and " + of_one);
}

}  // namespace

std::string seconds(double time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g s", time);
  return text;
}

std::string sureness_text(const MeansError& e, double weight, double until, bool met, const std::string& too_short,
                          const std::string& of_one) {
  if (!e.known()) {
    if (!(until > 0)) return "";
    return (weight > 0 ? "means over " + seconds(weight) + ": their errors are not known yet, for want of 8 batches"
                       : std::string("the means have not begun")) +
           "; 'until' wants a longer run";
  }
  std::string s = "means over " + seconds(weight) + ": standard error of the void fraction " + percent(e.eps) +
                  ", of the gas flux " + percent(e.flux) + " (" + std::to_string(e.batches) + " batches of " +
                  seconds(e.batch_time) +
                  (e.correlation_time > 0 ? ", correlation time " + seconds(e.correlation_time) : "") + ")";
  if (e.steady())
    s += "; the flow is steady, but for round-off";
  else if (!e.long_enough() && !met)
    s += "; the batches are shorter than four correlation times: the errors are larger than that";
  else if (!e.trusted()) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2g", e.lag);
    s += (e.long_enough() ? "; neighbouring batches are alike (correlation " + std::string(text) +
                                "), as where the flow changes slowly"
                          : std::string("; the batches are shorter than four correlation times")) +
         ": twice the scatter of a single batch, " + percent(MeansError::kDriftOver * e.scatter) +
         ", is the safer error";
  }
  if (until > 0 && !met) s += "; 'until' wants " + (too_short.empty() ? missing(e, weight, until, of_one) : too_short);
  return s;
}

}  // namespace twogrid
