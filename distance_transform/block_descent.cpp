// Which kernel this machine runs, and the memory that kernels work in.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/block_descent.h"

#include <cstdlib>
#include <new>

namespace isocast {

namespace baseline {
extern const DescentKernels kernels;
}
#ifdef ISOCAST_X86_KERNELS
namespace avx2 {
extern const DescentKernels kernels;
}
namespace avx512 {
extern const DescentKernels kernels;
}
#endif

DescentWorkspace::~DescentWorkspace() {
    std::free(memory_);
}

void* DescentWorkspace::memory(std::size_t bytes) {
    if (bytes <= bytes_) return memory_;
    constexpr std::size_t alignment = 64;
    // Half as much again, so that a growing demand is met by few allocations.
    const std::size_t wanted = (bytes + bytes / 2 + alignment - 1) / alignment * alignment;
    std::free(memory_);
    bytes_ = 0;
    memory_ = std::aligned_alloc(alignment, wanted);
    if (memory_ == nullptr) throw std::bad_alloc();
    bytes_ = wanted;
    return memory_;
}

bool is_available(InstructionSet set) {
    switch (set) {
    case InstructionSet::Baseline:
        return true;
#ifdef ISOCAST_X86_KERNELS
    case InstructionSet::Avx2:
        return __builtin_cpu_supports("avx2") != 0;
    case InstructionSet::Avx512:
        return __builtin_cpu_supports("avx512f") != 0;
#else
    case InstructionSet::Avx2:
    case InstructionSet::Avx512:
        return false;
#endif
    }
    return false;
}

const DescentKernels& descent_kernels(InstructionSet set) {
#ifdef ISOCAST_X86_KERNELS
    if (set == InstructionSet::Avx512) return avx512::kernels;
    if (set == InstructionSet::Avx2) return avx2::kernels;
#endif
    static_cast<void>(set);
    return baseline::kernels;
}

InstructionSet best_instruction_set() {
    if (is_available(InstructionSet::Avx512)) return InstructionSet::Avx512;
    if (is_available(InstructionSet::Avx2)) return InstructionSet::Avx2;
    return InstructionSet::Baseline;
}

} // namespace isocast
