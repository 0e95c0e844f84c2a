#include "liggghts_fixes/contacts/contact_kernel_code.h"

namespace twogrid {
const ContactKernel kContactKernelPlain{"plain",        pack,        near_pairs, neighbours, touching,
                                        contact_forces, wall_forces, add_weight, kick};
}
