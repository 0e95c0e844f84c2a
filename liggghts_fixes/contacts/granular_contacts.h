// The pair style gran model hooke/stiffness tangential history, evaluated by our own kernel: a wrapper around LIGGGHTS'
// object, which keeps settings, parameters, history and restart files. Same results to the last bit. What the kernel
// doesn't serve is left to LIGGGHTS' own, step by step.
#pragma once

#include <string>

#include "liggghts_fixes/contacts/contact_kernel.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace twogrid {

/// From here on LIGGGHTS makes the wrapper where the script asks for that pair style. Call once.
void register_contacts(const ContactKernel& kernel);

/// How contacts_text() begins where our kernel is used.
constexpr char kOwnContacts[] = "twogrid's kernel";
/// One sentence: what evaluates the contacts of this scene, and why; empty without a granular pair style.
std::string contacts_text(LAMMPS_NS::LAMMPS& lammps);

}  // namespace twogrid
