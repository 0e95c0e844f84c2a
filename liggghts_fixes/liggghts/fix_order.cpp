#include "liggghts_fixes/liggghts/fix_order.h"

#include <atom.h>
#include <fix.h>
#include <lammps.h>
#include <modify.h>

#include <algorithm>
#include <string>
#include <vector>

namespace twogrid {
namespace {

bool overwrites_forces(const LAMMPS_NS::Fix& fix) {
  static const char* const kStyles[] = {"freeze",    "setforce", "aveforce", "lineforce",  "planeforce",
                                        "enforce2d", "move",     "rigid",    "multisphere"};
  return std::any_of(std::begin(kStyles), std::end(kStyles),
                     [&](const char* s) { return std::string(s) == fix.style; });
}

}  // namespace

void move_behind_forces(LAMMPS_NS::LAMMPS& lammps, const char* style) {
  LAMMPS_NS::Modify& modify = *lammps.modify;
  LAMMPS_NS::Atom& atom = *lammps.atom;
  const int n = modify.nfix;

  std::vector<std::string> own;  // ids that move
  for (int i = 0; i < n; ++i) {
    if (std::string(modify.fix[i]->style) != style) continue;
    own.push_back(modify.fix[i]->id);
    const std::string id = own.back();
    own.push_back(id + "_state");
    own.push_back(id + "_step");
  }
  const auto moves = [&](int i) { return std::find(own.begin(), own.end(), modify.fix[i]->id) != own.end(); };

  int last_force = -1, first_own = n;
  for (int i = n - 1; i >= 0; --i) {
    if (moves(i)) {
      first_own = i;
    } else if (last_force < 0 && (modify.fmask[i] & LAMMPS_NS::FixConst::POST_FORCE) &&
               !overwrites_forces(*modify.fix[i])) {
      last_force = i;
    }
  }
  if (last_force < first_own) return;

  // new order: what stays up to last_force, then what moves (a fix before what it keeps), then the rest
  std::vector<int> order;
  for (int i = 0; i <= last_force; ++i)
    if (!moves(i)) order.push_back(i);
  for (const std::string& id : own) {
    const int i = modify.find_fix(id.c_str());
    if (i >= 0) order.push_back(i);
  }
  for (int i = last_force + 1; i < n; ++i)
    if (!moves(i)) order.push_back(i);

  std::vector<LAMMPS_NS::Fix*> fix(n);
  std::vector<int> mask(n), place(n);
  for (int i = 0; i < n; ++i) {
    fix[i] = modify.fix[order[i]];
    mask[i] = modify.fmask[order[i]];
    place[order[i]] = i;
  }
  std::copy(fix.begin(), fix.end(), modify.fix);
  std::copy(mask.begin(), mask.end(), modify.fmask);
  const auto renumber = [&](int* list, int count) {
    for (int i = 0; i < count; ++i) list[i] = place[list[i]];
  };
  renumber(atom.extra_grow, atom.nextra_grow);
  renumber(atom.extra_restart, atom.nextra_restart);
  renumber(atom.extra_border, atom.nextra_border);
}

}  // namespace twogrid
