#include "coupling/output/means.h"

#include <algorithm>
#include <cstdio>
#include <limits>

#include "cfd/fluid/fluid.h"
#include "coupling/output/flow_numbers.h"
#include "coupling/output/growing_file.h"
#include "coupling/output/sureness.h"
#include "coupling/output/wall_writer.h"

namespace twogrid {

Means::Means(MPI_Comm comm, const Fluid& fluid, const OutputSettings& settings, WallWriter& walls)
    : comm_(comm), fluid_(fluid), settings_(settings), walls_(walls) {
  for (const Axis& a : fluid.grid().axis) longest_ = std::max(longest_, a.length());
}

void Means::begin(const ParticleGrid& coarse) {
  if (settings_.average_from >= 0)
    averages_ = std::make_unique<Averages>(comm_, fluid_.grid(), fluid_.layout(), coarse);
  if (settings_.average_auto) start_up_ = std::make_unique<StartUp>(longest_);
}

void Means::set_driven(bool driven) {
  driven_ = driven;
  if (start_up_) start_up_->want_passes(driven);
}

std::string Means::add(double weight, const Particles& particles, double pressure_drop) {
  if (!averages_) return "";
  std::string news;
  if (start_up_) {
    const double begun = start_up_->begun();
    news = start_up_->add(fluid_.time(), weight, flow_numbers(comm_, fluid_, particles, settings_.up, pressure_drop));
    if (start_up_->begun() != begun) {
      begin_anew();
      return news;
    }
    if (!start_up_->over()) return news;
  }
  // Times are sums of steps: a time that differs by round-off from the wanted one counts as that.
  if (!(fluid_.time() >= settings_.average_from * (1 - 1e-12))) return news;
  averages_->add(weight, fluid_, particles);
  walls_.add(weight);
  if (settings_.until > 0 && averages_->samples_to_full_batch() == 0 && (!start_up_ || start_up_->has_looked())) {
    const MeansError e = averages_->error(at_rest());
    sure_enough_ = e.within(settings_.until, long_time(e));
  }
  return news;
}

void Means::begin_anew() {
  averages_->begin_anew();
  walls_.begin_means_anew();
  written_ = 0;
  sure_enough_ = false;
}

long long Means::samples_to_decide() const {
  // Where nothing has been summed up yet, or a batch is full, a sample is a batch.
  return averages_ ? std::max(1LL, averages_->samples_to_full_batch()) : 1;
}

std::string Means::sureness() const {
  if (!averages_) return "";
  if (start_up_ && !start_up_->over())
    return "start-up is not over, and there are no means: " + start_up_->why_not_over(fluid_.time());
  const MeansError e = averages_->error(at_rest());
  return sureness_text(e, averages_->weight(), settings_.until,
                       (!start_up_ || start_up_->has_looked()) && e.within(settings_.until, long_time(e)), too_short(),
                       of_one(e));
}

double Means::at_rest() const {
  return driven_ || !(averages_->weight() > 0) ? 0 : StartUp::kRest * longest_ / averages_->weight();
}

bool Means::long_time(const MeansError& e) const {
  if (start_up_) return start_up_->has_looked();
  return driven_ ? e.passes >= StartUp::kPasses
                 : settings_.average_from > 0 && averages_->weight() >= settings_.average_from;
}

std::string Means::too_short() const {
  return !start_up_ || start_up_->has_looked() ? ""
                                               : "means of a time as long as start-up was, which takes some " +
                                                     seconds(start_up_->next_look() - fluid_.time()) + " more";
}

std::string Means::of_one(const MeansError& e) const {
  if (long_time(e)) return "";
  if (driven_) {
    char text[96];
    std::snprintf(text, sizeof text, "the fluid has passed the domain's longest side %g times (now %.3g)",
                  StartUp::kPasses, e.passes);
    return text;
  }
  return settings_.average_from > 0 ? "the means are of a time as long as that before them"
                                    : "the means begin later than at 0";
}

void Means::average_as(const OutputSettings& now) {
  settings_.average_from = now.average_from, settings_.average_auto = now.average_auto, settings_.until = now.until;
  start_up_.reset();
  if (now.average_auto) {
    start_up_ = std::make_unique<StartUp>(longest_);
    start_up_->begin_anew(fluid_.time());
  }
  set_driven(driven_);
  begin_anew();
  anew_ = fluid_.time();
}

std::string Means::meet_other_conditions(const std::string& what, bool* warns) {
  *warns = !start_up_;
  if (!start_up_)
    return !averages_ || averages_->weight() == 0
               ? ""
               : what + ": the means go on from " + seconds(std::max(settings_.average_from, anew_)) +
                     ", and span both; for means of this run alone say 'output average from' a time, or auto, before "
                     "it";
  if (!start_up_->has_samples()) return "";
  start_up_->begin_anew(fluid_.time());
  begin_anew();
  return what + ": start-up and means begin anew at " + seconds(fluid_.time());
}

void Means::write(GrowingFile& file) {
  averages_->write(file);
  const MeansError e = averages_->error(at_rest());
  file.attribute("/average", "from", start_up_ ? start_up_->begun() : std::max(settings_.average_from, anew_));
  file.attribute("/average", "to", fluid_.time());
  const double none = std::numeric_limits<double>::quiet_NaN();
  file.attribute("/average", "standard_error_eps", e.known() ? e.eps : none);
  file.attribute("/average", "standard_error_flux", e.known() ? e.flux : none);
  file.attribute("/average", "correlation_time", e.known() ? e.correlation_time : none);
  written_ = averages_->weight();
}

}  // namespace twogrid
