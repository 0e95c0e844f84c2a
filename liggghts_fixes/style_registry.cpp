#include "liggghts_fixes/style_registry.h"

#include <input.h>
#include <lammps.h>
#include <modify.h>
#include <update.h>

#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "liggghts_fixes/contacts/fix_plane_wall.h"
#include "liggghts_fixes/contacts/fix_sphere_motion.h"
#include "liggghts_fixes/contacts/fix_weight.h"
#include "liggghts_fixes/contacts/granular_contacts.h"
#include "liggghts_fixes/contacts/neighbours.h"
#include "liggghts_fixes/fix_twogrid.h"
#include "liggghts_fixes/liggghts/fix_order.h"
#include "liggghts_fixes/private_member.h"
#include "liggghts_fixes/script/words.h"

namespace {

// LIGGGHTS' maps from style name to creator.

using FixCreator = LAMMPS_NS::Fix* (*)(LAMMPS_NS::LAMMPS*, int, char**);
using CommandCreator = void (*)(LAMMPS_NS::LAMMPS*, int, char**);

struct FixMap {
  using type = std::map<std::string, FixCreator>* LAMMPS_NS::Modify::*;
  friend type member(FixMap);
};
struct CommandMap {
  using type = std::map<std::string, CommandCreator>* LAMMPS_NS::Input::*;
  friend type member(CommandMap);
};
template struct PrivateMember<FixMap, &LAMMPS_NS::Modify::fix_map>;
template struct PrivateMember<CommandMap, &LAMMPS_NS::Input::command_map>;

LAMMPS_NS::Fix* make_fix_twogrid(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) {
  return new twogrid::FixTwogrid(lammps, narg, arg);
}

FixCreator stock_wall = nullptr;  // LIGGGHTS' own, as its map held it
const twogrid::ContactKernel* contact_kernel = nullptr;

/// While LIGGGHTS makes a fix of an ID that is there, the old one's place is empty, and walls of grains trip over it.
LAMMPS_NS::Fix* make_wall(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) {
  for (int i = 0; i < lammps->modify->nfix; ++i)
    if (!lammps->modify->fix[i])
      twogrid::refuse("fix " + std::string(arg[0]) + " wall/gran", "another fix of this ID",
                      "an ID of its own, or 'unfix " + std::string(arg[0]) + "' before it");
  LAMMPS_NS::Fix* plane = twogrid::make_plane_wall(lammps, narg, arg, *contact_kernel);
  return plane ? plane : stock_wall(lammps, narg, arg);
}

LAMMPS_NS::Fix* make_sphere_motion(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) {
  return new twogrid::FixSphereMotion(lammps, narg, arg, *contact_kernel);
}

LAMMPS_NS::Fix* make_weight(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) {
  return new twogrid::FixWeight(lammps, narg, arg, *contact_kernel);
}

void register_fixes(LAMMPS_NS::LAMMPS& lammps) {
  auto& fixes = *(lammps.modify->*member(FixMap{}));
  fixes[twogrid::FixTwogrid::kStyle] = make_fix_twogrid;
  if (!contact_kernel) return;
  fixes["nve/sphere"] = make_sphere_motion;
  fixes["gravity"] = make_weight;
  stock_wall = fixes["wall/gran"];
  fixes["wall/gran"] = make_wall;
  twogrid::replace_neighbour_lists(lammps, *contact_kernel);
}

std::map<std::string, CommandCreator> stock_command;  // LIGGGHTS' own, of those that are replaced

/// Every fix needs a box, and `clear` takes the box away: what makes one comes before any fix of a LIGGGHTS that
/// `clear` has made anew, without our styles.
template <const char* const& kName>
void make_box(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) {
  if (!(lammps->modify->*member(FixMap{}))->count(twogrid::FixTwogrid::kStyle)) register_fixes(*lammps);
  stock_command[kName](lammps, narg, arg);
}

/// Fixes of the last run: LIGGGHTS calls them by their places in the list.
std::vector<LAMMPS_NS::Fix*> fixes_of_run;
bool fluid_in_run = false;

bool without_setup(int narg, char** arg) {
  for (int i = 1; i + 1 < narg && std::string(arg[i]) != "every"; ++i)
    if (std::string(arg[i]) == "pre" && std::string(arg[i + 1]) == "no") return true;
  return false;
}

twogrid::RunHandler run_handler;

/// As LIGGGHTS has it, with the fixes in our order.
void run_as_it_is(LAMMPS_NS::LAMMPS* lammps, const char* name, std::vector<std::string> words) {
  std::vector<char*> arg;
  for (std::string& w : words) arg.push_back(w.data());
  LAMMPS_NS::Modify& modify = *lammps->modify;
  const auto fixes = [&] { return std::vector<LAMMPS_NS::Fix*>(modify.fix, modify.fix + modify.nfix); };
  const bool fluid = modify.n_fixes_style_strict(twogrid::FixTwogrid::kStyle) > 0;
  if (without_setup(int(arg.size()), arg.data()) && lammps->update->first_update && (fluid || fluid_in_run) &&
      fixes() != fixes_of_run)
    twogrid::refuse(name, "'pre no' after a fix was added or deleted since the last run",
                    "a run with set-up, which is LIGGGHTS' default: leave 'pre no' out");
  twogrid::move_behind_forces(*lammps, twogrid::FixTwogrid::kStyle);
  stock_command[name](lammps, int(arg.size()), arg.data());
  fixes_of_run = fixes();
  fluid_in_run = fluid;
}

template <const char* const& kName>
void run(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) {
  const std::vector<std::string> words(arg, arg + narg);
  if (run_handler) return run_handler(kName, words);
  run_as_it_is(lammps, kName, words);
}

constexpr const char *kCreateBox = "create_box", *kReadData = "read_data", *kReadRestart = "read_restart",
                     *kRun = "run", *kRunTime = "run_time", *kWriteRestart = "write_restart";

}  // namespace

namespace twogrid {

void register_styles(LAMMPS_NS::LAMMPS& lammps, const std::string& kernel) {
  if (kernel != "stock") {
    contact_kernel = find_contact_kernel(kernel.c_str());
    if (!contact_kernel)
      throw std::invalid_argument("command line: found -particles " + kernel +
                                  ", wanted auto, stock, plain, AVX2 or AVX-512 (where this processor has it)");
    register_contacts(*contact_kernel);
  }
  register_fixes(lammps);
  auto& commands = *(lammps.input->*member(CommandMap{}));
  const std::pair<const char*, CommandCreator> replaced[] = {{kCreateBox, make_box<kCreateBox>},
                                                             {kReadData, make_box<kReadData>},
                                                             {kReadRestart, make_box<kReadRestart>},
                                                             {kRun, run<kRun>},
                                                             {kRunTime, run<kRunTime>}};
  for (const auto& [name, ours] : replaced) {
    const auto stock = commands.find(name);
    if (stock == commands.end()) continue;
    stock_command[name] = stock->second;
    stock->second = ours;
  }
}

void handle_runs(RunHandler handler) {
  run_handler = std::move(handler);
}

void stock_run(LAMMPS_NS::LAMMPS& lammps, const std::string& name, const std::vector<std::string>& words) {
  run_as_it_is(&lammps, name == kRun ? kRun : kRunTime, words);
}

void stock_write_restart(LAMMPS_NS::LAMMPS& lammps, const std::string& path) {
  std::string words = path;  // LIGGGHTS may write into them
  char* arg[] = {words.data()};
  const auto& commands = *(lammps.input->*member(CommandMap{}));
  commands.at(kWriteRestart)(&lammps, 1, arg);
}

}  // namespace twogrid
