#include "liggghts_fixes/liggghts/insertion_state.h"

#include <fix.h>
#include <fix_insert.h>
#include <fix_insert_pack.h>
#include <fix_insert_stream.h>
#include <fix_particledistribution_discrete.h>
#include <lammps.h>
#include <modify.h>
#include <multi_node_mesh.h>
#include <probability_distribution.h>
#include <random_park.h>
#include <region.h>
#include <tri_mesh.h>

#include <algorithm>
#include <iomanip>
#include <iterator>
#include <set>
#include <sstream>
#include <type_traits>
#include <vector>

#include "cfd/parallel/ranks.h"
#include "coupling/checkpoint/state_file.h"
#include "liggghts_fixes/private_member.h"

namespace {

using namespace LAMMPS_NS;

PRIVATE_MEMBER(InsertRandom, FixInsert, RanPark*, random);
PRIVATE_MEMBER(HasEnd, FixInsert, int, ninsert_exists);
PRIVATE_MEMBER(Wanted, FixInsert, int, ninsert);
PRIVATE_MEMBER(Inserted, FixInsert, int, ninserted);
PRIVATE_MEMBER(Velocities, FixInsert, int, v_randomSetting);
PRIVATE_MEMBER(DistributionRandom, FixParticledistributionDiscrete, RanPark*, random);
PRIVATE_MEMBER(PackRegion, FixInsertPack, Region*, ins_region);
PRIVATE_MEMBER(PackVolume, FixInsertPack, double, region_volume);
PRIVATE_MEMBER(PackOwnVolume, FixInsertPack, double, region_volume_local);
PRIVATE_MEMBER(RegionRandom, Region, RanPark*, random);
PRIVATE_MEMBER(StreamFraction, FixInsertStream, double, ins_fraction);
PRIVATE_MEMBER(StreamCounts, FixInsertStream, bool, do_ins_fraction_calc);
PRIVATE_MEMBER(StreamParallel, FixInsertStream, bool, parallel);
PRIVATE_MEMBER(StreamFrom, FixInsertStream, double, extrude_length_min);
PRIVATE_MEMBER(StreamTo, FixInsertStream, double, extrude_length_max);
PRIVATE_MEMBER(MeshRandom, MultiNodeMesh<3>, RanPark*, random_);
PRIVATE_MEMBER(Kept, RanPark, int, save);
PRIVATE_MEMBER(Second, RanPark, double, second);

/// done(name, fix) for each insertion. Then, of those that go on: random(name, generator), once each; normal(name,
/// generator) for those that are asked for normal numbers too, of which they make two at a time; number(name, number).
template <class Done, class Random, class Normal, class Number>
void visit_insertion(LAMMPS& lammps, Done&& done, Random&& random, Normal&& normal, Number&& number) {
  std::set<const RanPark*> seen;
  const auto draw = [&](const std::string& name, RanPark* r) {
    if (r && seen.insert(r).second) random(name + "_random", r);
  };
  for (int i = 0; i < lammps.modify->nfix; ++i) {
    auto* insert = dynamic_cast<FixInsert*>(lammps.modify->fix[i]);
    if (!insert) continue;
    const std::string name = "fix_" + std::string(insert->id);
    done(name + "_done", *insert);
    if (insert->next_reneighbor <= 0) continue;
    draw(name, insert->*member(InsertRandom()));
    if (insert->*member(Velocities()) == RANDOM_GAUSSIAN) normal(name, insert->*member(InsertRandom()));
    FixParticledistributionDiscrete* const distribution = insert->get_distribution();
    draw("fix_" + std::string(distribution->id), distribution->*member(DistributionRandom()));
    if (auto* pack = dynamic_cast<FixInsertPack*>(insert)) {
      Region* const region = pack->*member(PackRegion());
      if (region) draw("region_" + std::string(region->id), region->*member(RegionRandom()));
      number(name + "_volume", pack->*member(PackVolume()));
      number(name + "_own_volume", pack->*member(PackOwnVolume()));
    }
    if (auto* stream = dynamic_cast<FixInsertStream*>(insert)) {
      MultiNodeMesh<3>* const face = stream->face();
      if (face) draw("fix_" + std::string(face->mesh_id()), face->*member(MeshRandom()));
      number(name + "_own_share", stream->*member(StreamFraction()));
      number(name + "_own_counts", stream->*member(StreamCounts()));
      if (!(stream->*member(StreamParallel()))) continue;
      number(name + "_own_from", stream->*member(StreamFrom()));
      number(name + "_own_to", stream->*member(StreamTo()));
    }
  }
}

/// Ends of names of what each rank has its own of.
constexpr const char* kOfARank[] = {"_random",     "_second",   "_own_volume", "_own_share",
                                    "_own_counts", "_own_from", "_own_to"};

bool of_a_rank(const std::string& name) {
  return std::any_of(std::begin(kOfARank), std::end(kOfARank), [&](const std::string& end) {
    return name.size() > end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0;
  });
}

/// As a name in a file's group.
std::string plain(std::string id) {
  std::replace(id.begin(), id.end(), '/', '_');
  return id;
}

}  // namespace

namespace twogrid {

using namespace LAMMPS_NS;

InsertionState::InsertionState(LAMMPS& lammps, bool to_read) {
  const auto put = [&](const std::string& name, double value) { numbers_.emplace_back(plain(name), value); };
  visit_insertion(
      lammps,
      [&](const std::string& name, const FixInsert& insert) {
        const bool done = insert.next_reneighbor == 0;
        if (done || to_read) put(name, done);
      },
      [&](const std::string& name, RanPark* random) { put(name, random->state()); },
      [&](const std::string& name, RanPark* random) {
        const bool kept = random->*member(Kept()) == 1;  // of a pair of normal numbers the second
        put(name + "_second", kept ? random->*member(Second()) : 0.0);
      },
      [&](const std::string& name, auto number) { put(name, double(number)); });
}

void InsertionState::forget_ranks() {
  numbers_.remove_if([](const auto& entry) { return of_a_rank(entry.first); });
}

void InsertionState::restore(LAMMPS& lammps) const {
  // Else they would find volumes and rates, by random points, in the next run's set-up.
  for (int i = 0; i < lammps.modify->nfix; ++i)
    if (auto* insert = dynamic_cast<FixInsert*>(lammps.modify->fix[i])) insert->init(), insert->setup(0);
  const auto find = [&](const std::string& name, double otherwise) {
    for (const auto& [known, value] : numbers_)
      if (known == plain(name) && !left_out("/insertion/" + known)) return value;
    return otherwise;
  };
  visit_insertion(
      lammps,
      [&](const std::string& name, FixInsert& insert) {
        // Not so where the script wants more by now.
        const bool more =
            insert.ins_every() > 0 && insert.*member(HasEnd()) && insert.*member(Inserted()) < insert.*member(Wanted());
        if (find(name, 0) == 1 && !more) insert.next_reneighbor = 0;
      },
      [&](const std::string& name, RanPark* random) {
        const double state = find(name, 0);
        if (state > 0) random->reset(int(state));
      },
      [&](const std::string& name, RanPark* random) {
        const double second = find(name + "_second", 0);
        random->*member(Kept()) = second != 0;
        random->*member(Second()) = second;
      },
      [&](const std::string& name, auto& number) {
        number = std::decay_t<decltype(number)>(find(name, double(number)));
      });
}

std::string InsertionState::text(MPI_Comm comm) const {
  const int me = rank_of(comm), ranks = ranks_of(comm);
  std::ostringstream out;
  out << std::setprecision(17);
  for (const auto& [name, value] : numbers_) out << me << ' ' << std::quoted(name) << ' ' << value << '\n';
  const std::string own = out.str();
  const int bytes = int(own.size());
  std::vector<int> counts(ranks, 0), begins(ranks, 0);
  MPI_Gather(&bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  for (int r = 1; r < ranks; ++r) begins[r] = begins[r - 1] + counts[r - 1];
  std::string all(me == 0 ? begins[ranks - 1] + counts[ranks - 1] : 0, ' ');
  MPI_Gatherv(own.data(), bytes, MPI_CHAR, all.data(), counts.data(), begins.data(), MPI_CHAR, 0, comm);
  return me == 0 ? std::to_string(ranks) + "\n" + all : "";
}

InsertionState::InsertionState(const std::string& text, int rank, int ranks) {
  std::istringstream in(text);
  int then = 0, r = 0;
  in >> then;
  std::string name;
  for (double value = 0; in >> r >> std::quoted(name) >> value;)
    if (r == (then == ranks ? rank : 0)) numbers_.emplace_back(name, value);
  if (then != ranks) forget_ranks();
}

}  // namespace twogrid
