#include "liggghts_fixes/contacts/contact_kernel.h"

#include <cstring>

namespace twogrid {

const ContactKernel* find_contact_kernel(const char* name) {
  const bool avx512 =
      __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
  const bool any = std::strcmp(name, "auto") == 0;
  if (avx512 && (any || std::strcmp(name, kContactKernelAvx512.name) == 0)) return &kContactKernelAvx512;
  if (__builtin_cpu_supports("avx2") && (any || std::strcmp(name, kContactKernelAvx2.name) == 0))
    return &kContactKernelAvx2;
  if (any || std::strcmp(name, kContactKernelPlain.name) == 0) return &kContactKernelPlain;
  return nullptr;
}

}  // namespace twogrid
