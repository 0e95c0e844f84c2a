#include "liggghts_fixes/contacts/neighbours.h"

#include <atom.h>
#include <error.h>
#include <fix_contact_history.h>
#include <lammps.h>
#include <my_page.h>
#include <neigh_list.h>
#include <neigh_request.h>

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

/// What fix contacthistory shows to LIGGGHTS' Neighbor only.
struct History : FixContactHistory {
  static int* counts(FixContactHistory& f) { return f.*&History::npartner_; }
  static int** tags(FixContactHistory& f) { return f.*&History::partner_; }
  static double** values(FixContactHistory& f) { return f.*&History::contacthistory_; }
};

/// Bins a particle from which on LIGGGHTS' own way is faster: it visits the bins near particles only (measured with
/// 2000 particles: even at some 200).
constexpr double kManyBins = 100;
constexpr int kLanes = 4;  // of the kernel
constexpr double kNowhere = 1e300;

}  // namespace

void Neighbours::choose_build(int index, NeighRequest* request) {
  Neighbor::choose_build(index, request);
  if (pair_build[index] == static_cast<PairPtr>(&Neighbours::granular_bin_no_newton))
    pair_build[index] = static_cast<PairPtr>(&Neighbours::find_pairs);
}

/// LIGGGHTS' lists of a bin's particles run through own ones by index, then ghosts; so do these.
void Neighbours::sort_by_bins() {
  const int n = atom->nlocal + atom->nghost;
  const std::size_t padded = std::size_t(n) + kLanes;
  for (std::vector<double>* a : {&x_, &y_, &z_, &r_}) a->resize(padded);
  index_.resize(padded);
  bin_.resize(n);
  start_.resize(std::size_t(mbins) + 1);
  int at = 0;
  for (int b = 0; b < mbins; ++b) {
    start_[b] = at;
    for (int j = binhead[b]; j >= 0; j = bins[j], ++at) {
      const double* x = atom->x[j];
      x_[at] = x[0], y_[at] = x[1], z_[at] = x[2], r_[at] = atom->radius[j];
      index_[at] = j;
      bin_[j] = b;
    }
  }
  start_[mbins] = at;
  for (int l = 0; l < kLanes; ++l) x_[at + l] = y_[at + l] = z_[at + l] = kNowhere, r_[at + l] = 0, index_[at + l] = -1;
}

void Neighbours::find_runs(const NeighList& list) {
  runs_.clear();
  for (int k = 0; k < list.nstencil; ++k) {
    if (!runs_.empty() && list.stencil[k] == runs_.back().first + runs_.back().bins)
      ++runs_.back().bins;
    else
      runs_.push_back({list.stencil[k], 1});
  }
}

void Neighbours::find_pairs(NeighList* list) {
  FixContactHistory* const history = list->fix_history;
  const bool sparse = mbins > kManyBins * (atom->nlocal + atom->nghost + 1.0);
  if (includegroup || exclude || sparse || !history || !list->listgranhistory) {
    granular_bin_no_newton(list);
    return;
  }
  bin_atoms();
  sort_by_bins();
  find_runs(*list);
  const int* const counts = History::counts(*history);
  int* const* const tags = History::tags(*history);
  double* const* const values = History::values(*history);
  NeighList& springs = *list->listgranhistory;
  const int doubles = springs.dnum;
  list->ipage->reset();
  springs.ipage->reset();
  springs.dpage->reset();
  found_.resize(std::size_t(atom->nlocal) + atom->nghost + kLanes);
  const Binned binned{x_.data(), y_.data(), z_.data(), r_.data(), index_.data()};

  for (int i = 0; i < atom->nlocal; ++i) {
    int* const neighbours = list->ipage->vget();
    int* const flags = springs.ipage->vget();
    double* value = springs.dpage->vget();
    if (!neighbours || !flags || !value) error->one(FLERR, "Neighbor list overflow, boost neigh_modify one");
    const double *const x = atom->x[i], r = atom->radius[i];
    const PairCutoff reach{x[0], x[1], x[2], r, contactDistanceFactor, skin, i};
    const int n =
        kernel_.neighbours(binned, start_.data() + bin_[i], runs_.data(), int(runs_.size()), reach, found_.data());
    if (n > list->oneatom) error->one(FLERR, "Neighbor list overflow, boost neigh_modify one");
    list->firstneigh[i] = neighbours;
    springs.firstneigh[i] = flags;
    springs.firstdouble[i] = value;
    for (int k = 0; k < n; ++k, value += doubles) {
      const int j = neighbours[k] = found_[k];
      const double* y = atom->x[j];
      const double dx = x[0] - y[0], dy = x[1] - y[1], dz = x[2] - y[2];
      const double touch = (r + atom->radius[j]) * contactDistanceFactor;
      int partner = counts[i];
      if (dx * dx + dy * dy + dz * dz < touch * touch)
        for (partner = 0; partner < counts[i] && tags[i][partner] != atom->tag[j];) ++partner;
      const bool known = partner < counts[i];
      flags[k] = known;
      for (int d = 0; d < doubles; ++d) value[d] = known ? values[i][partner * doubles + d] : 0.0;
    }
    list->ilist[i] = i;
    list->numneigh[i] = n;
    list->ipage->vgot(n);
    springs.ipage->vgot(n);
    springs.dpage->vgot(n * doubles);
    if (list->ipage->status()) error->one(FLERR, "Neighbor list overflow, boost neigh_modify one");
  }
  list->inum = atom->nlocal;
}

void replace_neighbour_lists(LAMMPS& lammps, const ContactKernel& kernel) {
  Neighbor* const stock = lammps.neighbor;
  lammps.neighbor = new Neighbours(*stock, kernel);
  ::operator delete(stock);  // not its destructor: what it owned is the new one's
}

}  // namespace twogrid
