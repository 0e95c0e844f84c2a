// The command line, what a run asks for, and the records that checkpoints keep as text.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "coupling/checkpoint/checksum.h"
#include "liggghts_fixes/run/checkpoint_folder.h"
#include "liggghts_fixes/run/command_line.h"
#include "liggghts_fixes/run/resume_point.h"
#include "liggghts_fixes/run/run_request.h"
#include "tests/fuzz/fuzz.h"

namespace twogrid_fuzz {
namespace {

using namespace twogrid;
using Lines = std::vector<std::vector<std::string>>;

ResumePoint some_point(Dice& dice) {
  ResumePoint p;
  p.variables = {{"n", "1", "2"}, {"name", "a \"quoted\" word"}};
  p.files = {{"in.bed", 120, "0123456789abcdef"}, {"more.in", 7, "0123456789abcdef"}};
  p.line = "run ${n} every 10 \"print 'x'\"";
  p.pending = {"fix a all nve", "run 1"};
  p.jump_skip = dice.one_in(2);
  p.done = {{"units", "si"}, {"variable", "a", "equal", "1"}, {"fix", "gas", "all", "twogrid", "fine", "8", "8", "8"}};
  p.run = {"run", "1000"};
  p.begin = 100, p.end = 1100, p.step = 100 + (long long)dice.below(1000), p.time = 1e-5 * double(p.step),
  p.particles = 1200;
  return p;
}

std::string senseless(const ResumePoint& p) {
  constexpr double kMost = 9e15;
  std::vector<Bound> b{{"step", double(p.step), 0, kMost},
                       {"time", p.time, -1e12, 1e12},
                       {"particles", double(p.particles), 0, kMost},
                       {"begin", double(p.begin), 0, kMost},
                       {"end", double(p.end), 0, kMost}};
  if (!p.run.empty()) b.push_back({"step in its run", double(p.step), double(p.begin), double(p.end)});
  for (const OpenScript& f : p.files) b.push_back({"place in a script", double(f.at), 0, 9.3e18});
  for (const Command& c : p.done) b.push_back({"words of a command", double(c.size()), 1, kMost});
  return outside(b);
}

std::string file_text(const std::string& path) {
  std::ostringstream s;
  s << std::ifstream(path, std::ios::binary).rdbuf();
  return s.str();
}
void put(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

}  // namespace

Verdict try_command_line(Dice& dice) {
  static const Lines kLines{
      {"twogrid", "-in", "in.bed"},
      {"twogrid", "-in", "in.bed", "-log", "log.bed", "-screen", "none", "-echo", "both"},
      {"twogrid", "-in", "in.bed", "-restart", "auto", "-var", "n", "1", "2", "3"},
      {"twogrid", "-restart", "a.restart", "a.data"},
      {"twogrid", "-keywords"},
      {"twogrid", "-in", "x", "-particles", "stock", "-balance", "off", "-skin", "best"},
      {"twogrid", "-i", "x", "-fluid_pressure_rtol", "1e-12", "-log_view", "-fluid_bricks", "1,1,4"}};
  std::vector<std::string> words = dice.of(kLines);
  for (std::size_t n = dice.below(4); n > 0; --n) mutate(words, dice, kLines);
  if (words.empty()) words = {"twogrid"};
  note(joined(words));
  CommandLine c;
  Verdict v = tried([&] { c = split_command_line(words); }, words);
  if (!v.accepted) return v;
  std::size_t given = 0;
  for (const std::string& w : words) given += w == "-in" || w == "-i";
  v.defect = outside({{"words for LIGGGHTS", double(c.liggghts.size()), 1, double(words.size())},
                      {"words for PETSc", double(c.petsc.size()), 1, double(words.size())},
                      {"-restart of a run without a script", double(!c.restart.empty() && given == 0), 0, 0}});
  return v;
}

Verdict try_run_request(Dice& dice) {
  static const Lines kLines{{"run", "1000"},
                            {"run", "1000", "upto", "start", "0", "stop", "2000"},
                            {"run", "1000", "pre", "no", "post", "no"},
                            {"run", "1000", "every", "100", "print x", "print y"},
                            {"run", "1000", "every", "100", "NULL"},
                            {"run_time", "0.1"},
                            {"run_time", "0.1", "upto", "every", "10", "NULL"}};
  static const std::vector<double> kSteps{1e-5, 0, -1, NAN, INFINITY, 1e-300, 5e-324, 1e300, 1};
  static const std::vector<long long> kNow{0, 100, 1000000, 2147483648, 9000000000000000000, 9223372036854775807, -1};
  std::vector<std::string> words = dice.of(kLines);
  for (std::size_t n = dice.below(3); n > 0; --n) mutate(words, dice, kLines);
  const double dt = dice.one_in(3) ? dice.of(kSteps) : 1e-5;
  const long long now = dice.one_in(2) ? 0 : dice.of(kNow);
  note(joined(words) + " at " + std::to_string(now) + ", dt " + std::to_string(dt));
  Verdict v;
  std::optional<RunRequest> r;
  v = tried([&] { r = run_request(words, now, dt); }, words);
  if (!v.accepted || !r) return v.accepted = false, v;
  v.defect =
      outside({{"end of a run", double(r->end), double(r->begin), 9.3e18}, {"every", double(r->every), 0, 9e15}});
  long long step = r->begin;
  for (int part = 0; part < 20 && step < r->end && v.defect.empty(); ++part) {
    const long long to = r->part_end(step);
    v.defect = outside({{"end of a part", double(to), double(step), double(r->end)},
                        {"steps of a part", double(to - step), 1, 2147483647}});
    if (r->words(step, to, true).size() % 2 != 1) v.defect = "words of run that are no pairs";
    step = to;
  }
  return v;
}

Verdict try_resume_point(Dice& dice) {
  std::string text = to_text(some_point(dice));
  for (std::size_t n = dice.below(3); n > 0; --n) mutate_text(text, dice);
  note(text);
  ResumePoint p;
  Verdict v = tried([&] { p = resume_point(text); }, {});
  if (v.accepted) v.defect = senseless(p);
  if (v.accepted && v.defect.empty() && to_text(resume_point(to_text(p))) != to_text(p))
    v.defect = "a record that is read otherwise";
  return v;
}

Verdict try_checkpoint_folder(Dice& dice) {
  static const std::string kFolder = folder() + "/in.bed.checkpoints";
  static const std::string kPath = [&] {
    const CheckpointFolder f(kFolder);
    const std::string part = f.begin(1000);
    put(part + "/" + kParticlesFile, std::string(500, 'p'));
    put(part + "/gas.h5", std::string(900, 'g'));
    Dice first(1);
    return f.complete(some_point(first), 2, 0);
  }();
  static const std::string kRecord = file_text(kPath + "/record.txt");
  std::string text = kRecord.substr(0, kRecord.rfind("checksum "));
  for (std::size_t n = dice.below(3); n > 0; --n) mutate_text(text, dice);
  text += "checksum " + text_checksum(text) + "\n";
  if (dice.one_in(5)) mutate_bytes(text, dice);
  put(kPath + "/record.txt", text);
  static const std::vector<std::string> kNames{
      "9999999999999999999_step_1",      "000002_step_", "_step_1", "-3_step_4",
      "000003_step_9999999999999999999", "000004_step_x"};
  const std::string beside = kFolder + "/" + dice.of(kNames);
  std::filesystem::create_directory(beside);
  note(text);
  Checkpoint c;
  std::vector<std::string> names;
  Verdict v = tried([&] { c = find_checkpoint(kFolder), names = CheckpointFolder(kFolder).names(); }, {});
  std::filesystem::remove(beside);
  if (!v.accepted) return v.defect = "it throws: " + v.defect, v;
  for (const std::string& s : c.passed_over)
    if (s.find(" is not used: ") == std::string::npos || s.size() > 2000)
      v.defect = "passed over without a sentence: " + s;
  if (c.path.empty()) {
    v.accepted = false;
    if (c.passed_over.empty()) v.defect = "passed over in silence";
    return v;
  }
  ResumePoint p;
  const Verdict record = tried([&] { p = resume_point(c.record); }, {});
  v.defect = record.defect;
  if (record.accepted && v.defect.empty()) v.defect = senseless(p);
  return v;
}

}  // namespace twogrid_fuzz
