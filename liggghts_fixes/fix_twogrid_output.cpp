// What fix twogrid does for output: frames, means, and runs that end when these are sure enough.
#include <update.h>

#include <cmath>
#include <limits>

#include "liggghts_fixes/fix_twogrid.h"
#include "liggghts_fixes/liggghts/run_record.h"
#include "liggghts_fixes/liggghts/scene_facts.h"
#include "liggghts_fixes/run/replay.h"
#include "liggghts_fixes/run/still_files.h"
#include "liggghts_fixes/script/keywords.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

using namespace LAMMPS_NS;

void FixTwogrid::open_output(const SceneFacts& facts) {
  OutputSettings& out = script_.settings.output;
  if (!out.writes()) return;
  if (files_are_still()) return open_planned_output(facts);
  Record record = run_record(*lmp);
  record.settings = settings_texts(script_);
  out.keep_old = restarting();
  const Vec3& g = facts.gravity;
  const double size = std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  for (int d = 0; d < 3 && size > 0; ++d) out.up[d] = -g[d] / size;
  output_ = std::make_unique<Output>(world, script_.settings, *fluid_, record);
  conditions_.average_said = out.average_said;
}

bool FixTwogrid::takes_means() const {
  return output_ && output_->averages();
}

/// A run begins: as the one before ended, or with other conditions of the flow, which means must not hold together in silence.
void FixTwogrid::meet_conditions() {
  if (!takes_means() || files_are_still()) return;
  const OutputSettings& out = script_.settings.output;
  output_->set_driven(names_.drives_flow());
  if (conditions_.average_said != out.average_said) {
    output_->average_as(out);
    conditions_.average_said = out.average_said;
    planned_end_ = PlannedEnd{};
    watch_.say("twogrid: the means begin anew, as 'output average from' says\n");
  } else if (conditions_.known) {
    const std::string what = change_of(conditions_.value, names_.conditions());
    bool warns = false;
    const std::string sentence = what.empty() ? "" : output_->meet_other_conditions(what, &warns);
    if (!what.empty() && !warns) planned_end_ = PlannedEnd{};
    if (!sentence.empty()) warns ? watch_.warn(sentence) : watch_.say("twogrid: " + sentence + "\n");
  }
  conditions_.known = false;
}

void FixTwogrid::note_conditions() {
  if (!takes_means()) return;
  conditions_.value.clear();
  for (const FlowCondition& c : names_.conditions()) conditions_.value.push_back(c.value);
  conditions_.known = true;
}

/// For a checkpoint.
NumberList FixTwogrid::conditions_kept() {
  // To be read: as many as there will be.
  if (conditions_.value.empty()) conditions_.value.resize(names_.conditions().size());
  NumberList list{"conditions", {{"known", &conditions_.known}, {"means_anew", &output_->means_anew()}}, true};
  for (std::size_t i = 0; i < conditions_.value.size(); ++i)
    list.numbers.push_back({"value_" + std::to_string(i), &conditions_.value[i]});
  return list;
}

void FixTwogrid::end_coupling() {
  schedule_.end_step();
  guarded([&] {
    if (output_) {
      Particles p = particles();
      {
        const Stopwatch watch = times_.output();
        const std::string news = output_->average(schedule_.interval(), p, coupling_->report().pressure_drop);
        if (!news.empty()) watch_.say("twogrid: " + news + "\n");
      }
      if (ends_by_itself() && planned_end_.step == 0 && output_->sure_enough()) {
        planned_end_.step = update->ntimestep + script_.settings.every;
        watch_.say("twogrid: the means are as sure as 'until' wants: the run ends at step " +
                   std::to_string(planned_end_.step) + "\n");
      }
      if (frame_due()) write_frame(p);
    }
    watch_.tell_progress(times_.done(update->ntimestep), coupling_->report(), schedule_);
  });
}

bool FixTwogrid::ends_by_itself() const {
  return output_ && script_.settings.output.until > 0 && !planned_end_.reached;
}

long long FixTwogrid::steps_undecided() const {
  if (!ends_by_itself()) return std::numeric_limits<int>::max();
  // With accuracy the interval changes between couplings.
  const long long every = script_.settings.every, samples = accuracy_.on() ? 1 : output_->samples_to_decide();
  const long long now = update->ntimestep;
  return accuracy_.on() && script_.every_auto ? std::max(1LL, every - schedule_.steps())
                                              : (now / every + samples) * every - now;
}

long long FixTwogrid::steps_to_end() const {
  return ends_by_itself() && planned_end_.step > 0 ? planned_end_.step - update->ntimestep : 0;
}

void FixTwogrid::tell_sureness() {
  const std::string sure = output_ ? output_->sureness() : "";
  if (!sure.empty()) watch_.say("twogrid: " + sure + "\n");
}

bool FixTwogrid::stands_at_planned_end() const {
  return ends_by_itself() && planned_end_.step > 0 && update->ntimestep >= planned_end_.step;
}

bool FixTwogrid::frame_due() const {
  return output_ && !files_are_still() && schedule_.frame_due(update->ntimestep, script_.settings.output.every);
}

void FixTwogrid::write_frame(const Particles& p) {
  const Stopwatch watch = times_.output();
  output_->frame(coupling_->report().fluid_time, long(update->ntimestep), p);
  schedule_.frame_written(update->ntimestep, script_.settings.output.every);
}

}  // namespace twogrid
