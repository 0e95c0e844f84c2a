#include "coupling/checkpoint/state_check.h"

#include <map>

#include "cfd/fluid/fluid_state.h"
#include "coupling/coupling_state.h"
#include "coupling/output/averages.h"
#include "coupling/output/start_up.h"

namespace twogrid {

namespace {

// The fluid's void fraction may lie above 1: between two couplings it is followed smoothly.
constexpr double kAny = 1e30, kCount = 9e15, kLeast = 1e-9, kMost = 2;
constexpr EntryRange kFinite{-kAny, kAny}, kSums{-1e100, 1e100}, kAmount{0, kAny}, kNumber{0, kCount},
    kInt{0, 2147483647}, kVoid{0, kMost}, kOpen{kLeast, 1 + 1e-6};

bool begins(const std::string& s, const char* with) {
  return s.rfind(with, 0) == 0;
}

}  // namespace

EntryRange range_of(const std::string& path) {
  static const std::map<std::string, EntryRange> kRanges{{"/fluid/time", kAmount},
                                                         {"/fluid/dt_previous", kAmount},
                                                         {"/fluid/dt_older", kAmount},
                                                         {"/fluid/idle_steps", kInt},
                                                         {"/fluid/largest_viscosity", kAmount},
                                                         {"/fluid/eps_open", kVoid},
                                                         {"/coupling/drag_number", kAmount},
                                                         {"/coupling/follow", kAmount},
                                                         {"/coupling/known_volume", kAmount},
                                                         {"/coupling/repeated", kInt},
                                                         {"/coupling/history_now", kOpen},
                                                         {"/coupling/history_interval", kAmount},
                                                         {"/coupling/deposit_eps", kOpen},
                                                         {"/coupling/deposit_largest_radius", kAmount},
                                                         {"/coupling/deposit_volume_of_rank", kAmount},
                                                         {"/coupling/deposit_particles", kNumber},
                                                         {"/coupling/change_rest_eps", kOpen},
                                                         {"/coupling/change_eps", {-1, 1}},
                                                         {"/coupling/motion_mass", kAmount},
                                                         {"/coupling/motion_terms", kAmount},
                                                         {"/coupling/motion_beta", kAmount},
                                                         {"/coupling/step_last_dt", kAmount},
                                                         {"/coupling/step_decay_dt", kAmount},
                                                         {"/coupling/fluid_steps", kNumber},
                                                         {"/schedule/steps", kInt},
                                                         {"/schedule/time", kAmount},
                                                         {"/schedule/interval", kAmount},
                                                         {"/schedule/next_frame", kNumber},
                                                         {"/schedule/particles", {-1, kCount}},
                                                         {"/schedule/lost", kNumber},
                                                         {"/schedule/told", kNumber},
                                                         {"/report/eps_min", kVoid},
                                                         {"/averages/samples", kNumber},
                                                         {"/averages/batch", {0, AveragesState::kBatches - 1}},
                                                         {"/averages/batch_length", {1, kCount}},
                                                         {"/averages/batch_samples", kNumber},
                                                         {"/start_up/bins", {0, StartUp::kBins - 1}},
                                                         {"/start_up/bin_length", {1, kCount}},
                                                         {"/start_up/bin_samples", kNumber},
                                                         {"/start_up/next_look", kAmount},
                                                         {"/start_up/looks", kInt},
                                                         {"/start_up/restarts", kInt},
                                                         {"/start_up/origin", kAmount},
                                                         {"/accuracy/fluid_step", {1e-12, 1}},
                                                         {"/accuracy/coupling_step", {1, 2147483647}}};
  const auto row = kRanges.find(path);
  if (row != kRanges.end()) return row->second;
  if (begins(path, "/fluid/eps_")) return kVoid;  // a share of it may be closed
  return begins(path, "/averages/") ? kSums : kFinite;
}

std::string broken_promise(const FluidState& f, const CouplingState& c, const StateShape& shape) {
  const Box& cells = shape.own_cells;
  if (cells.empty()) return "";
  std::string wrong;
  const auto want = [&](const std::string& name, const Array3<double>& a, const Box& box, bool needed) {
    if (wrong.empty() && (needed || a.size() > 0) && !(a.box() == box))
      wrong = name + " is not there, or of another size";
  };
  // Of three, all are there or none.
  const auto want_all = [&](const std::string& name, const auto& a, const Box& box, bool needed) {
    for (int d = 0; d < 3; ++d)
      want(name + "_" + "xyz"[d], a[d], box, needed || a[0].size() + a[1].size() + a[2].size() > 0);
  };
  const bool fed = !shape.one_way;  // the fluid feels the particles
  want("response", f.response, f.p.box(), false);
  want("change_rest_eps", c.change.rest_eps, c.deposit.eps.box(), fed);
  want("change_eps", c.change.eps, c.history.now.box(), c.change.changed);
  const bool motion = c.motion.drag || (fed && c.holding) || c.motion.beta.size() > 0 || c.motion.v_n[0].size() > 0 ||
                      c.motion.v_flux[0].size() > 0;
  want("motion_beta", c.motion.beta, shape.own_nodes, motion);
  want_all("motion_v_flux", c.motion.v_flux, shape.own_nodes, motion);
  want_all("motion_v_n", c.motion.v_n, shape.own_nodes, motion);
  if (wrong.empty() && !(c.started && c.change.resting)) wrong = "started and change_resting say that no run has ended";
  return wrong;
}

}  // namespace twogrid
