#include "liggghts_fixes/run/command_line.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <stdexcept>

#include "liggghts_fixes/script/words.h"

namespace twogrid {
namespace {

/// LIGGGHTS' switches that make sense for one world, with the number of words that follow.
const std::map<std::string, int>& liggghts_switches() {
  static const std::map<std::string, int> kSwitches{
      {"-in", 1},   {"-i", 1},      {"-log", 1},     {"-l", 1},    {"-screen", 1}, {"-sc", 1},
      {"-var", 2},  {"-v", 2},      {"-echo", 1},    {"-e", 1},    {"-thermo", 1}, {"-seedtolerant", 0},
      {"-st", 0},   {"-nocite", 0}, {"-nc", 0},      {"-help", 0}, {"-h", 0},      {"-suffix", 1},
      {"-sf", 1},   {"-wb", 0},     {"-restart", 2}, {"-r", 2},    {"-uid", 1},    {"-restart_offset", 3},
      {"-roff", 3}, {"-domain", 1}};
  return kSwitches;
}

bool is_petsc(const std::string& word) {
  static const char* const kBeginnings[] = {"-fluid_",   "-ksp_",    "-pc_",      "-mat_",
                                            "-vec_",     "-snes_",   "-dm_",      "-da_",
                                            "-log_",     "-options", "-info",     "-malloc",
                                            "-memory",   "-petsc",   "-on_error", "-start_in_debugger",
                                            "-debugger", "-fp_trap", "-history",  "-get_total_flops",
                                            "-sf_type",  "-is_",     "-sub_",     "-mg_",
                                            "-viewer",   "-show_",   "-check_",   "-nox",
                                            "-display",  "-draw",    "-prefix_"};
  return std::any_of(std::begin(kBeginnings), std::end(kBeginnings),
                     [&](const std::string& b) { return word.rfind(b, 0) == 0; });
}

bool is_switch(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && !(word[1] >= '0' && word[1] <= '9') && word[1] != '.';
}

}  // namespace

CommandLine split_command_line(const std::vector<std::string>& words) {
  CommandLine c;
  c.liggghts.push_back(words.at(0));
  c.petsc.push_back(words.at(0));
  const bool has_script =
      std::any_of(words.begin(), words.end(), [](const auto& w) { return w == "-in" || w == "-i"; });
  for (std::size_t i = 1; i < words.size();) {
    const std::string& name = words[i++];
    if (name == "-restart" && has_script) {
      if (i == words.size() || words[i][0] == '-')
        throw std::invalid_argument(
            "command line: found -restart without a name, wanted the folder of checkpoints to go on from, or auto");
      c.restart = words[i++];
      continue;
    }
    const auto known = liggghts_switches().find(name);
    if (known != liggghts_switches().end()) {
      c.liggghts.push_back(name);
      for (int k = 0; k < known->second; ++k) {
        if (i == words.size())
          throw std::invalid_argument("command line: found " + name + " at the end, wanted " +
                                      std::to_string(known->second) + " more word(s) after it");
        c.liggghts.push_back(words[i++]);
      }
      if ((name == "-screen" || name == "-sc") && c.liggghts.back() == "none") c.liggghts.back() = "/dev/null";
      if (name == "-in" || name == "-i") c.script = c.liggghts.back();
      if (name == "-log" || name == "-l") c.log = c.liggghts.back();
      if (name == "-var" || name == "-v") {  // a variable may have several values
        while (i < words.size() && words[i][0] != '-') c.liggghts.push_back(words[i++]);
        const auto at = std::find(c.liggghts.rbegin(), c.liggghts.rend(), name).base();
        c.variables.emplace_back(at, c.liggghts.end());
      }
    } else if (name == "-plan" || name == "--plan") {
      c.plan = kPlanSeconds;
      if (i < words.size() && words[i][0] != '-') {
        char* end = nullptr;
        c.plan = std::strtod(words[i].c_str(), &end);
        if (*end != '\0' || !(c.plan > 0 && c.plan < 1e6))
          throw std::invalid_argument("command line: found -plan " + words[i] +
                                      ", wanted -plan, perhaps with the seconds to measure for");
        ++i;
      }
    } else if (name == "-version" || name == "--version") {
      c.version = true;
    } else if (name == "-keywords" || name == "--keywords") {
      c.keywords = true;
    } else if (name == "-particles") {
      if (i == words.size())
        throw std::invalid_argument(
            "command line: found -particles at the end, wanted auto, stock or a kernel's name after it");
      c.particles = words[i++];
    } else if (is_petsc(name) || name == "-balance" || name == "-skin") {
      c.petsc.push_back(name);
      if (i < words.size() && !is_switch(words[i])) c.petsc.push_back(words[i++]);
    } else {
      throw std::invalid_argument(
          "command line: found " + shown(name) +
          ", wanted one of LIGGGHTS' switches (-in, -var, -log, -screen, -echo, ...) or a PETSc "
          "option (-fluid_pressure_..., -ksp_..., -log_view, ...)");
    }
  }
  return c;
}

}  // namespace twogrid
