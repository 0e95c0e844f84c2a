// The time means of a run's output: when they begin, how sure they are, when they begin anew. The sums themselves: averages.h;
// the end of start-up: start_up.h.
#pragma once

#include <mpi.h>

#include <memory>
#include <string>

#include "coupling/output/averages.h"
#include "coupling/output/start_up.h"
#include "coupling/settings.h"

namespace twogrid {

class WallWriter;

class Means {
 public:
  /// fluid and walls must live as long.
  Means(MPI_Comm comm, const Fluid& fluid, const OutputSettings& settings, WallWriter& walls);
  /// coarse, with its open part, is copied.
  void begin(const ParticleGrid& coarse);

  /// As those of Output (output.h).
  std::string add(double weight, const Particles& particles, double pressure_drop);
  bool sure_enough() const { return sure_enough_; }
  long long samples_to_decide() const;
  std::string sureness() const;
  void set_driven(bool driven);
  void average_as(const OutputSettings& settings);
  std::string meet_other_conditions(const std::string& what, bool* warns);
  Averages* averages() { return averages_.get(); }
  StartUp* start_up() { return start_up_.get(); }
  double& anew() { return anew_; }

  bool there() const { return averages_ && averages_->weight() > 0; }
  /// There, and not written yet.
  bool are_new() const { return there() && averages_->weight() != written_; }
  /// See Averages::bytes().
  double bytes() const { return averages_->bytes(); }
  /// Writes /average with its attributes. Collective.
  void write(GrowingFile& file);

 private:
  void begin_anew();
  double at_rest() const;
  bool long_time(const MeansError& e) const;
  std::string too_short() const;
  std::string of_one(const MeansError& e) const;

  MPI_Comm comm_;
  const Fluid& fluid_;
  OutputSettings settings_;
  WallWriter& walls_;
  std::unique_ptr<Averages> averages_;  // only if wanted
  std::unique_ptr<StartUp> start_up_;   // the same
  double longest_ = 0;                  // side of the domain (m)
  bool driven_ = true, sure_enough_ = false;
  double anew_ = 0;     // time (s), see Output::means_anew()
  double written_ = 0;  // weight of those in the file
};

}  // namespace twogrid
