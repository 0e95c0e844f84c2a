#include "liggghts_fixes/contacts/contact_laws.h"

#include <atom.h>
#include <force.h>
#include <lammps.h>
#include <property_registry.h>
#include <update.h>

#include <algorithm>
#include <tuple>

namespace twogrid {
namespace {

auto numbers(const ContactLaw& l) {
  return std::make_tuple(l.kn, l.kt, l.gn, l.gt, l.mu);
}

}  // namespace

ContactSettings read_contact_settings(const std::vector<std::string>& words) {
  ContactSettings s;
  for (std::size_t w = 0; w < words.size(); w += 2) {
    const std::string& name = words[w];
    const std::string value = w + 1 < words.size() ? words[w + 1] : "";
    const bool on = value == "on";
    if (name == "absolute_damping")
      s.absolute_damping = on;
    else if (name == "tangential_damping")
      s.tangential_damping = on;
    else if (name == "limitForce")
      s.limit_force = on;
    else if (value != "off")
      s.unknown = name + " " + value;
  }
  return s;
}

ContactLaws::ContactLaws(LAMMPS_NS::LAMMPS& lammps, const ContactSettings& settings)
    : settings_(settings), types_(lammps.atom->ntypes + 1), law_(std::size_t(types_) * types_) {
  // LIGGGHTS' tables, made anew in every set-up, reach to the highest type in use: by a particle, a wall, an insertion.
  int used = types_;
  auto matrix = [&](const char* name) {
    const MatrixProperty& table = *lammps.force->registry.getMatrixProperty(name, "twogrid contacts");
    used = std::min({used, table.rows, table.cols});
    return table.data;
  };
  double **kn = matrix("k_n"), **kt = matrix("k_t"), **mu = matrix("coeffFrict");
  double** gn = matrix(settings.absolute_damping ? "gamman_abs" : "gamman");
  double** gt = matrix(settings.absolute_damping ? "gammat_abs" : "gammat");
  const double unit = lammps.force->nktv2p;
  one_ = true;
  for (int i = 1; i < used; ++i)
    for (int j = 1; j < used; ++j) {
      law_[i * types_ + j] = {kn[i][j] / unit, kt[i][j] / unit, gn[i][j], settings.tangential_damping ? gt[i][j] : 0.0,
                              mu[i][j]};
      one_ = one_ && numbers(law_[i * types_ + j]) == numbers(law_[types_ + 1]);
    }
}

ContactStep ContactLaws::step(LAMMPS_NS::LAMMPS& lammps, bool advance, int frozen) const {
  return {one_ ? &law_[types_ + 1] : law_.data(),
          types_,
          one_,
          settings_.absolute_damping,
          settings_.limit_force,
          advance,
          frozen,
          lammps.update->dt};
}

Spheres spheres(LAMMPS_NS::LAMMPS& lammps) {
  const LAMMPS_NS::Atom& atom = *lammps.atom;
  return {atom.nlocal,   atom.nlocal + atom.nghost,
          atom.x[0],     atom.v[0],
          atom.omega[0], atom.radius,
          atom.rmass,    atom.type,
          atom.mask,     atom.f[0],
          atom.torque[0]};
}

}  // namespace twogrid
