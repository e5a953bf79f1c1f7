// Which kernel this machine runs.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/scan_kernel.h"

namespace isocast {

namespace baseline {
std::int64_t scan(const ScanInput& input, ScanOutput& output);
}
#ifdef ISOCAST_X86_KERNELS
namespace avx2 {
std::int64_t scan(const ScanInput& input, ScanOutput& output);
}
namespace avx512 {
std::int64_t scan(const ScanInput& input, ScanOutput& output);
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

ScanKernel scan_kernel(InstructionSet set) {
#ifdef ISOCAST_X86_KERNELS
    if (set == InstructionSet::Avx512) return avx512::scan;
    if (set == InstructionSet::Avx2) return avx2::scan;
#endif
    static_cast<void>(set);
    return baseline::scan;
}

} // namespace isocast
