#include "liggghts_fixes/liggghts/rank_parts.h"

#include <atom.h>
#include <atom_vec.h>
#include <comm.h>
#include <domain.h>
#include <lammps.h>
#include <memory.h>
#include <modify.h>
#include <mpi.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "cfd/parallel/ranks.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

constexpr std::size_t kMostOfOne = 20000;  // values with which a particle goes to another rank, at most

template <class T>
MPI_Datatype type_of();
template <>
MPI_Datatype type_of<int>() {
  return MPI_INT;
}
template <>
MPI_Datatype type_of<double>() {
  return MPI_DOUBLE;
}

/// to[r]: for rank r. Returns what came from each.
template <class T>
std::vector<std::vector<T>> all_to_all(MPI_Comm comm, const std::vector<std::vector<T>>& to) {
  const std::size_t ranks = to.size();
  std::vector<int> out(ranks), in(ranks), out_at(ranks), in_at(ranks);
  for (std::size_t r = 0; r < ranks; ++r) out[r] = int(to[r].size());
  MPI_Alltoall(out.data(), 1, MPI_INT, in.data(), 1, MPI_INT, comm);
  std::exclusive_scan(out.begin(), out.end(), out_at.begin(), 0);
  std::exclusive_scan(in.begin(), in.end(), in_at.begin(), 0);
  std::vector<T> sent, got(std::size_t(in_at.back()) + in.back());
  for (const std::vector<T>& part : to) sent.insert(sent.end(), part.begin(), part.end());
  MPI_Alltoallv(sent.data(), out.data(), out_at.data(), type_of<T>(), got.data(), in.data(), in_at.data(), type_of<T>(),
                comm);
  std::vector<std::vector<T>> from(ranks);
  for (std::size_t r = 0; r < ranks; ++r)
    from[r].assign(got.begin() + in_at[r], got.begin() + in_at[r] + std::ptrdiff_t(in[r]));
  return from;
}

/// Rank that wants each of this rank's particles; -1: none. Asked of the rank that a tag's number names.
std::vector<int> who_wants(MPI_Comm comm, const Atom& atom, const std::vector<int>& wanted) {
  const int ranks = ranks_of(comm);
  std::vector<std::vector<int>> want(ranks), have(ranks), answer(ranks);
  for (int tag : wanted) want[tag % ranks].push_back(tag);
  for (int i = 0; i < atom.nlocal; ++i) have[atom.tag[i] % ranks].push_back(atom.tag[i]);
  std::unordered_map<int, int> wanted_by;
  want = all_to_all(comm, want);
  for (int r = 0; r < ranks; ++r)
    for (int tag : want[r]) wanted_by[tag] = r;
  have = all_to_all(comm, have);
  for (int r = 0; r < ranks; ++r)
    for (int tag : have[r]) {
      const auto found = wanted_by.find(tag);
      answer[r].push_back(found == wanted_by.end() ? -1 : found->second);
    }
  answer = all_to_all(comm, answer);
  std::vector<int> who(atom.nlocal);
  std::vector<std::size_t> next(ranks, 0);
  for (int i = 0; i < atom.nlocal; ++i) {
    const int r = atom.tag[i] % ranks;
    who[i] = answer[r][next[r]++];
  }
  return who;
}

/// Particles go to the ranks that want them.
void migrate(LAMMPS& lammps, std::vector<int> who) {
  Atom& atom = *lammps.atom;
  std::vector<std::vector<double>> to(lammps.comm->nprocs);
  std::vector<double> one(kMostOfOne);
  for (int i = 0; i < atom.nlocal;) {
    if (who[i] == lammps.comm->me) {
      ++i;
      continue;
    }
    const int values = atom.avec->pack_exchange(i, one.data());
    to[who[i]].insert(to[who[i]].end(), one.begin(), one.begin() + values);
    const int last = --atom.nlocal;
    atom.avec->copy(last, i, 1);
    who[i] = who[last];
  }
  for (std::vector<double>& from : all_to_all(lammps.world, to))
    for (std::size_t at = 0; at < from.size();) at += std::size_t(atom.avec->unpack_exchange(&from[at]));
}

/// old[i]: place in memory, so far, of what is to be at place i.
void permute(Atom& atom, const std::vector<int>& old) {
  if (atom.nlocal == atom.nmax) atom.avec->grow(0);
  std::vector<bool> done(old.size(), false);
  for (int i = 0; i < atom.nlocal; ++i) {
    if (done[i] || old[i] == i) continue;
    atom.avec->copy(i, atom.nlocal, 0);  // aside
    int at = i;
    for (; old[at] != i; at = old[at]) {
      atom.avec->copy(old[at], at, 0);
      done[at] = true;
    }
    atom.avec->copy(atom.nlocal, at, 0);
    done[at] = true;
  }
}

/// What a restart file holds of the particles for fixes that are yet to be made (contact histories are, by the first
/// run): rows of atom->extra, which LIGGGHTS leaves where they are.
class RestartRows {
 public:
  RestartRows(LAMMPS& lammps, const std::vector<int>& who) : lammps_(lammps), width_(lammps.atom->nextra_store) {
    const Atom& atom = *lammps.atom;
    if (lammps.modify->nfix_restart_peratom == 0 || !atom.extra) width_ = 0;
    if (width_ == 0) return;
    std::vector<std::vector<double>> to(lammps.comm->nprocs);
    for (int i = 0; i < atom.nlocal; ++i) {
      to[who[i]].push_back(atom.tag[i]);
      to[who[i]].insert(to[who[i]].end(), atom.extra[i], atom.extra[i] + width_);
    }
    from_ = all_to_all(lammps.world, to);
  }
  /// The particles are where they are to be.
  void put() {
    if (width_ == 0) return;
    Atom& atom = *lammps_.atom;
    std::unordered_map<int, const double*> row;
    for (const std::vector<double>& part : from_)
      for (std::size_t at = 0; at < part.size(); at += std::size_t(width_) + 1) row[int(part[at])] = &part[at + 1];
    lammps_.memory->destroy(atom.extra);
    lammps_.memory->create(atom.extra, atom.nmax, width_, "atom:extra");
    for (int i = 0; i < atom.nlocal; ++i) std::copy_n(row.at(atom.tag[i]), width_, atom.extra[i]);
  }

 private:
  LAMMPS& lammps_;
  int width_;
  std::vector<std::vector<double>> from_;
};

}  // namespace

RankParts rank_parts(LAMMPS& lammps) {
  const Comm& comm = *lammps.comm;
  RankParts parts;
  const double* const split[3] = {comm.xsplit, comm.ysplit, comm.zsplit};
  for (int d = 0; d < 3; ++d) {
    parts.bricks[d] = comm.procgrid[d];
    parts.borders[d].assign(split[d], split[d] + comm.procgrid[d] + 1);
  }
  parts.equal = comm.uniform != 0;
  parts.ordered = true;
  parts.tags.assign(lammps.atom->tag, lammps.atom->tag + lammps.atom->nlocal);
  return parts;
}

bool restore_borders(LAMMPS& lammps, const RankParts& parts) {
  Comm& comm = *lammps.comm;
  for (int d = 0; d < 3; ++d)
    if (parts.bricks[d] != comm.procgrid[d] || int(parts.borders[d].size()) != comm.procgrid[d] + 1) return false;
  double* const split[3] = {comm.xsplit, comm.ysplit, comm.zsplit};
  for (int d = 0; d < 3; ++d) std::copy(parts.borders[d].begin(), parts.borders[d].end(), split[d]);
  comm.uniform = parts.equal;
  lammps.domain->set_local_box();
  return true;
}

void restore_order(LAMMPS& lammps, const RankParts& parts) {
  Atom& atom = *lammps.atom;
  const std::vector<int> who = who_wants(lammps.world, atom, parts.tags);
  int strange[2] = {int(std::count(who.begin(), who.end(), -1)), int(parts.tags.size()) - atom.nlocal};
  MPI_Allreduce(MPI_IN_PLACE, strange, 2, MPI_INT, MPI_SUM, lammps.world);
  if (strange[0] != 0 || strange[1] != 0)
    throw std::invalid_argument(
        "checkpoint read: found other particles than those of the checkpoint (" + std::to_string(strange[0]) +
        " of other IDs), wanted those of the restart file written with it, with no command between that adds, deletes "
        "or numbers particles");
  if (atom.map_style) atom.map_clear();
  atom.nghost = 0;
  RestartRows rows(lammps, who);
  migrate(lammps, who);
  std::unordered_map<int, int> place;
  for (int i = 0; i < atom.nlocal; ++i) place[atom.tag[i]] = i;
  std::vector<int> old;
  old.reserve(parts.tags.size());
  for (int tag : parts.tags) old.push_back(place.at(tag));
  permute(atom, old);
  rows.put();
  if (atom.map_style) atom.map_set();
}

}  // namespace twogrid
