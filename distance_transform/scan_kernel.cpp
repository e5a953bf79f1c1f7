// Which kernels this machine runs.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/scan_kernel.h"

namespace isocast {

namespace baseline {
extern const ScanKernels kernels;
}
#ifdef ISOCAST_X86_KERNELS
namespace avx2 {
extern const ScanKernels kernels;
}
namespace avx512 {
extern const ScanKernels kernels;
}
#endif

bool is_available(InstructionSet set) {
    switch (set) {
    case InstructionSet::Baseline:
        return true;
#ifdef ISOCAST_X86_KERNELS
    case InstructionSet::Avx2:
        return __builtin_cpu_supports("avx2") != 0;
    case InstructionSet::Avx512:
        return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0;
#else
    case InstructionSet::Avx2:
    case InstructionSet::Avx512:
        return false;
#endif
    }
    return false;
}

InstructionSet best_instruction_set() {
    if (is_available(InstructionSet::Avx512)) return InstructionSet::Avx512;
    if (is_available(InstructionSet::Avx2)) return InstructionSet::Avx2;
    return InstructionSet::Baseline;
}

const ScanKernels& scan_kernels(InstructionSet set) {
#ifdef ISOCAST_X86_KERNELS
    if (set == InstructionSet::Avx512) return avx512::kernels;
    if (set == InstructionSet::Avx2) return avx2::kernels;
#endif
    static_cast<void>(set);
    return baseline::kernels;
}

} // namespace isocast
