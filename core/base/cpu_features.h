#pragma once

namespace camrig {

/// Whether this processor has AVX2: loops that are compiled twice take the wider one then. Always false on processors
/// of other families.
inline bool has_avx2() {
#if defined(__x86_64__)
    static const bool has = __builtin_cpu_supports("avx2");
    return has;
#else
    return false;
#endif
}

}  // namespace camrig
