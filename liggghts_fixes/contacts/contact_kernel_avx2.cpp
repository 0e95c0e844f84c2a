#include "liggghts_fixes/contacts/contact_kernel_code.h"

namespace twogrid {
const ContactKernel kContactKernelAvx2{"AVX2",         pack,        near_pairs, neighbours, touching,
                                       contact_forces, wall_forces, add_weight, kick};
}
