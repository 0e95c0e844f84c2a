#include "liggghts_fixes/contacts/granular_contacts.h"

#include <atom.h>
#include <force.h>
#include <granular_pair_style.h>
#include <lammps.h>
#include <modify.h>
#include <neigh_list.h>
#include <neighbor.h>
#include <pair_gran.h>
#include <pair_gran_proxy.h>

#include <cstdint>
#include <map>
#include <memory>

#include "liggghts_fixes/contacts/contact_laws.h"
#include "liggghts_fixes/contacts/near_list.h"
#include "liggghts_fixes/private_member.h"

namespace {

using LIGGGHTS::PairStyles::IGranularPairStyle;
using PairFactory = LIGGGHTS::Utils::AbstractFactory<IGranularPairStyle>;
using Creator = IGranularPairStyle* (*)(LAMMPS_NS::LAMMPS*, LAMMPS_NS::PairGran*, int64_t);
struct StyleTable {
  using type = std::map<std::pair<std::string, int>, Creator> PairFactory::*;
  friend type member(StyleTable);
};
struct ProxyStyle {
  using type = IGranularPairStyle* LAMMPS_NS::PairGranProxy::*;
  friend type member(ProxyStyle);
};
template struct PrivateMember<StyleTable, &PairFactory::styleTable>;
template struct PrivateMember<ProxyStyle, &LAMMPS_NS::PairGranProxy::impl>;

}  // namespace

namespace twogrid {
namespace {

using namespace LAMMPS_NS;

constexpr int kHookeStiffness = 1, kTangentialHistory = 2;
constexpr int kVariant = kHookeStiffness | kTangentialHistory << 6;
constexpr int kSpringSize = 3;

Creator stock_creator = nullptr;  // LIGGGHTS' own, as its registry held it
const ContactKernel* chosen_kernel = nullptr;

class GranularContacts : public IGranularPairStyle {
 public:
  GranularContacts(LAMMPS* lammps, PairGran* parent, int64_t hash)
      : lammps_(*lammps), stock_(stock_creator(lammps, parent, hash)) {
    settings_.unknown = "a pair style that only a restart file has set";
  }

  void settings(int narg, char** arg, LIGGGHTS::IContactHistorySetup* history) override {
    settings_ = read_contact_settings({arg, arg + narg});
    stock_->settings(narg, arg, history);
  }
  void init_granular() override {
    stock_->init_granular();
    near_.reset();
    laws_.reset();
  }
  void write_restart_settings(FILE* f) override { stock_->write_restart_settings(f); }
  void read_restart_settings(FILE* f, int64_t hash) override { stock_->read_restart_settings(f, hash); }
  int get_history_offset(const std::string name) override { return stock_->get_history_offset(name); }
  double stressStrainExponent() override { return stock_->stressStrainExponent(); }
  int64_t hashcode() override { return stock_->hashcode(); }
  bool contact_match(const std::string type, const std::string model) override {
    return stock_->contact_match(type, model);
  }

  void compute_force(PairGran* pair, int eflag, int vflag, int addflag) override;

  /// Why LIGGGHTS' own kernel is used; empty: it isn't.
  std::string obstacle(PairGran& pair) const;

 private:
  LAMMPS& lammps_;
  std::unique_ptr<IGranularPairStyle> stock_;
  ContactSettings settings_;
  std::unique_ptr<ContactLaws> laws_;
  std::unique_ptr<NearList> near_;
  bool stale_ = false;  // LIGGGHTS made its list anew in a step that its own kernel served
};

std::string GranularContacts::obstacle(PairGran& pair) const {
  Modify& modify = *lammps_.modify;
  if (!settings_.unknown.empty()) return settings_.unknown;
  if (!lammps_.atom->sphere_flag || !lammps_.atom->rmass)
    return "particles that are not spheres with masses of their own";
  if (pair.dnum_pair() != kSpringSize || !pair.is_history()) return "a history of other models";
  if (pair.fr_pair() || modify.n_fixes_style("multisphere") > 0) return "rigid bodies";
  if (pair.storeContactForces() || pair.storeContactForcesStress() || pair.storeSumDelta() ||
      pair.store_sum_normal_force())
    return "another fix or compute wants each contact's force";
  if (modify.n_fixes_style("relax_contacts") > 0) return "fix relax_contacts";
  if (modify.n_fixes_style("insert/stream/predefined") > 0) return "fix insert/stream/predefined";
  if (lammps_.neighbor->contactDistanceFactor != 1.0) return "contact_distance_factor";
  if (lammps_.force->newton_pair) return "newton on";
  return "";
}

void GranularContacts::compute_force(PairGran* pair, int eflag, int vflag, int addflag) {
  const int n_all = lammps_.atom->nlocal + lammps_.atom->nghost;
  const bool fresh = lammps_.neighbor->ago == 0;
  // The kernel reads one double behind the last particle's vectors.
  if (eflag || vflag || addflag || !pair->computeflag() || n_all >= lammps_.atom->nmax || !obstacle(*pair).empty()) {
    stale_ |= fresh;
    stock_->compute_force(pair, eflag, vflag, addflag);
    return;
  }
  pair->evflag = pair->vflag_fdotr = 0;
  if (!laws_) laws_ = std::make_unique<ContactLaws>(lammps_, settings_);
  if (!near_) near_ = std::make_unique<NearList>(*chosen_kernel, lammps_.neighbor->skin);
  const Spheres s = spheres(lammps_);
  const NeighList &list = *pair->list, &history = *pair->listgranhistory;
  near_->update(
      s, {list.inum, list.ilist, list.numneigh, list.firstneigh, history.firstneigh, history.firstdouble, pair->dnum()},
      fresh || stale_);
  stale_ = false;
  chosen_kernel->contact_forces(s, laws_->step(lammps_, pair->shearupdate() != 0, pair->freeze_group_bit()),
                                near_->packed(), near_->pairs(), near_->contacts(), near_->contact_count());
}

IGranularPairStyle* make_contacts(LAMMPS* lammps, PairGran* parent, int64_t hash) {
  return new GranularContacts(lammps, parent, hash);
}

}  // namespace

void register_contacts(const ContactKernel& kernel) {
  chosen_kernel = &kernel;
  auto& table = LIGGGHTS::PairStyles::Factory::instance().*member(StyleTable());
  const auto style = table.find({"gran", kVariant});
  if (style == table.end()) return;  // a LIGGGHTS built without it evaluates it by its general way
  stock_creator = style->second;
  style->second = make_contacts;
}

std::string contacts_text(LAMMPS& lammps) {
  auto* proxy = dynamic_cast<PairGranProxy*>(lammps.force->pair);
  if (!proxy) return "";
  auto* ours = dynamic_cast<GranularContacts*>(proxy->*member(ProxyStyle()));
  if (!ours) return "LIGGGHTS' own kernel: ours serves hooke/stiffness with tangential history";
  const std::string why = ours->obstacle(*proxy);
  if (!why.empty()) return "LIGGGHTS' own kernel: ours doesn't serve " + why;
  return std::string(kOwnContacts) + " (" + chosen_kernel->name + "), with LIGGGHTS' results to the last bit";
}

}  // namespace twogrid
