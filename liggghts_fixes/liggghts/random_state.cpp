#include "liggghts_fixes/liggghts/random_state.h"

#include <domain.h>
#include <fix.h>
#include <fix_insert.h>
#include <fix_insert_pack.h>
#include <fix_insert_stream.h>
#include <fix_mesh.h>
#include <fix_particledistribution_discrete.h>
#include <lammps.h>
#include <modify.h>
#include <multi_node_mesh.h>
#include <random_park.h>
#include <region.h>

#include <algorithm>
#include <iomanip>
#include <iterator>
#include <sstream>
#include <type_traits>
#include <vector>

#include "cfd/parallel/ranks.h"
#include "liggghts_fixes/private_member.h"

namespace {

using namespace LAMMPS_NS;

PRIVATE_MEMBER(RegionRandom, Region, RanPark*, random);
PRIVATE_MEMBER(InsertRandom, FixInsert, RanPark*, random);
PRIVATE_MEMBER(PackVolume, FixInsertPack, double, region_volume);
PRIVATE_MEMBER(PackOwnVolume, FixInsertPack, double, region_volume_local);
PRIVATE_MEMBER(Inserted, FixInsert, int, ninserted);
PRIVATE_MEMBER(InsertedMass, FixInsert, double, massinserted);
PRIVATE_MEMBER(FirstStep, FixInsert, int, first_ins_step);
PRIVATE_MEMBER(RecentStep, FixInsert, int, most_recent_ins_step);
PRIVATE_MEMBER(FinalStep, FixInsert, int, final_ins_step);
PRIVATE_MEMBER(StreamFraction, FixInsertStream, double, ins_fraction);
PRIVATE_MEMBER(StreamCounts, FixInsertStream, bool, do_ins_fraction_calc);
PRIVATE_MEMBER(MeshRandom, MultiNodeMesh<3>, RanPark*, random_);
PRIVATE_MEMBER(DistributionRandom, FixParticledistributionDiscrete, RanPark*, random);
PRIVATE_MEMBER(Kept, RanPark, int, save);
PRIVATE_MEMBER(Second, RanPark, double, second);

/// Calls f(name, generator) and g(name, number) for all that there are; after f normal(name, generator) for those that
/// are asked for normal numbers too, of which they make two at a time.
template <class F, class G, class H>
void for_each(LAMMPS& lammps, F&& f, G&& g, H&& normal) {
  Domain& domain = *lammps.domain;
  for (int r = 0; r < domain.nregion; ++r)
    f("region_" + std::string(domain.regions[r]->id), domain.regions[r]->*member(RegionRandom()));
  Modify& modify = *lammps.modify;
  for (int i = 0; i < modify.nfix; ++i) {
    const std::string name = "fix_" + std::string(modify.fix[i]->id);
    if (auto* insert = dynamic_cast<FixInsert*>(modify.fix[i])) {
      f(name, insert->*member(InsertRandom())), normal(name, insert->*member(InsertRandom()));
      g(name + "_inserted", insert->*member(Inserted())), g(name + "_mass", insert->*member(InsertedMass()));
      g(name + "_first", insert->*member(FirstStep())), g(name + "_recent", insert->*member(RecentStep()));
      g(name + "_final", insert->*member(FinalStep())), g(name + "_next", insert->next_reneighbor);
    }
    if (auto* stream = dynamic_cast<FixInsertStream*>(modify.fix[i])) {
      g(name + "_own_share", stream->*member(StreamFraction()));
      g(name + "_own_counts", stream->*member(StreamCounts()));
    }
    if (auto* surface = dynamic_cast<FixMesh*>(modify.fix[i]))
      if (auto* mesh = dynamic_cast<MultiNodeMesh<3>*>(surface->mesh())) f(name, mesh->*member(MeshRandom()));
    if (auto* pack = dynamic_cast<FixInsertPack*>(modify.fix[i])) {
      g(name + "_volume", pack->*member(PackVolume()));
      g(name + "_own_volume", pack->*member(PackOwnVolume()));
    }
    if (auto* distribution = dynamic_cast<FixParticledistributionDiscrete*>(modify.fix[i]))
      f(name, distribution->*member(DistributionRandom()));
  }
}

/// Ends of names of what each rank has its own of.
constexpr const char* kOfARank[] = {"_random", "_kept", "_second", "_own_volume", "_own_share", "_own_counts"};

/// As a name in a file's group.
std::string plain(std::string id) {
  std::replace(id.begin(), id.end(), '/', '_');
  return id;
}

}  // namespace

namespace twogrid {

using namespace LAMMPS_NS;

RandomState::RandomState(LAMMPS& lammps) {
  for_each(
      lammps,
      [&](const std::string& name, RanPark* random) {
        if (!random) return;
        numbers_.emplace_back(plain(name) + "_random", random->state());
      },
      [&](const std::string& name, auto number) { numbers_.emplace_back(plain(name), double(number)); },
      [&](const std::string& name, RanPark* random) {
        if (!random) return;
        const bool kept = random->*member(Kept()) == 1;  // of a pair of normal numbers the second
        numbers_.emplace_back(plain(name) + "_kept", kept);
        numbers_.emplace_back(plain(name) + "_second", kept ? random->*member(Second()) : 0.0);
      });
}

void RandomState::restore(LAMMPS& lammps) const {
  // Else they would find volumes and rates, by random points, in the next run's set-up.
  for (int i = 0; i < lammps.modify->nfix; ++i)
    if (auto* insert = dynamic_cast<FixInsert*>(lammps.modify->fix[i])) insert->init(), insert->setup(0);
  const auto find = [&](const std::string& name, double otherwise) {
    for (const auto& [known, value] : numbers_)
      if (known == plain(name)) return value;
    return otherwise;
  };
  for_each(
      lammps,
      [&](const std::string& name, RanPark* random) {
        const double state = find(name + "_random", 0);
        if (!random || !(state > 0)) return;
        random->reset(int(state));
      },
      [&](const std::string& name, auto& number) {
        number = std::decay_t<decltype(number)>(find(name, double(number)));
      },
      [&](const std::string& name, RanPark* random) {
        if (!random) return;
        random->*member(Kept()) = find(name + "_kept", 0) == 1;
        random->*member(Second()) = find(name + "_second", 0);
      });
}

std::string RandomState::text(MPI_Comm comm) const {
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

RandomState::RandomState(const std::string& text, int rank, int ranks) {
  std::istringstream in(text);
  int then = 0, r = 0;
  in >> then;
  std::string name;
  const auto of_a_rank = [](const std::string& n) {
    return std::any_of(std::begin(kOfARank), std::end(kOfARank), [&](const std::string& end) {
      return n.size() > end.size() && n.compare(n.size() - end.size(), end.size(), end) == 0;
    });
  };
  for (double value = 0; in >> r >> std::quoted(name) >> value;)
    if (then == ranks ? r == rank : r == 0 && !of_a_rank(name)) numbers_.emplace_back(name, value);
}

}  // namespace twogrid
