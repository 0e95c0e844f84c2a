#include "liggghts_fixes/contacts/contact_kernel_code.h"

namespace twogrid {
const ContactKernel kContactKernelAvx512{"AVX-512",      pack,        near_pairs, neighbours, touching,
                                         contact_forces, wall_forces, add_weight, kick};
}
