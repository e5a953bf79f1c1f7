// Eight doubles side by side, in as many registers as the instruction set asks for.
//
// Included inside a namespace of its own for each instruction set; knows builtin types only.

#if defined(__AVX512F__)
constexpr int native_lanes = 8;
#elif defined(__AVX__)
constexpr int native_lanes = 4;
#else
constexpr int native_lanes = 2;
#endif
constexpr int lanes = 8;
constexpr int part_count = lanes / native_lanes;

typedef double NativeDouble __attribute__((vector_size(8 * native_lanes)));
typedef long long NativeMask __attribute__((vector_size(8 * native_lanes)));

#define ISOCAST_INLINE inline __attribute__((always_inline))
#define ISOCAST_PARTS(k) for (int k = 0; k < part_count; ++k)

struct Mask {
    NativeMask part[part_count];
};

struct Lanes {
    NativeDouble part[part_count];
    Lanes() = default;
    ISOCAST_INLINE Lanes(double x) {
        ISOCAST_PARTS(k) part[k] = NativeDouble{} + x;
    }
};

#define ISOCAST_LANES_OPERATOR(op)                                                                 \
    ISOCAST_INLINE Lanes operator op(const Lanes& a, const Lanes& b) {                             \
        Lanes result;                                                                              \
        ISOCAST_PARTS(k) result.part[k] = a.part[k] op b.part[k];                                  \
        return result;                                                                             \
    }
ISOCAST_LANES_OPERATOR(+)
ISOCAST_LANES_OPERATOR(-)
ISOCAST_LANES_OPERATOR(*)
ISOCAST_LANES_OPERATOR(/)
#undef ISOCAST_LANES_OPERATOR

#define ISOCAST_LANES_COMPARISON(op)                                                               \
    ISOCAST_INLINE Mask operator op(const Lanes& a, const Lanes& b) {                              \
        Mask result;                                                                               \
        ISOCAST_PARTS(k) result.part[k] = a.part[k] op b.part[k];                                  \
        return result;                                                                             \
    }
ISOCAST_LANES_COMPARISON(<)
ISOCAST_LANES_COMPARISON(<=)
ISOCAST_LANES_COMPARISON(==)
#undef ISOCAST_LANES_COMPARISON

ISOCAST_INLINE Mask operator&(const Mask& a, const Mask& b) {
    Mask result;
    ISOCAST_PARTS(k) result.part[k] = a.part[k] & b.part[k];
    return result;
}
ISOCAST_INLINE Mask operator|(const Mask& a, const Mask& b) {
    Mask result;
    ISOCAST_PARTS(k) result.part[k] = a.part[k] | b.part[k];
    return result;
}
ISOCAST_INLINE Lanes select(const Mask& m, const Lanes& a, const Lanes& b) {
    Lanes result;
    ISOCAST_PARTS(k) result.part[k] = m.part[k] ? a.part[k] : b.part[k];
    return result;
}
ISOCAST_INLINE Lanes min(const Lanes& a, const Lanes& b) { return select(a < b, a, b); }
ISOCAST_INLINE Lanes max(const Lanes& a, const Lanes& b) { return select(b < a, a, b); }
ISOCAST_INLINE Lanes sqrt(const Lanes& a) {
    Lanes result;
    ISOCAST_PARTS(k)
        for (int i = 0; i < native_lanes; ++i) result.part[k][i] = __builtin_sqrt(a.part[k][i]);
    return result;
}
ISOCAST_INLINE double lane(const Lanes& a, int i) {
    return a.part[i / native_lanes][i % native_lanes];
}
ISOCAST_INLINE Lanes load(const double* p) {
    Lanes result;
    __builtin_memcpy(&result, p, sizeof result);
    return result;
}
ISOCAST_INLINE void store(double* p, const Lanes& a) { __builtin_memcpy(p, &a, sizeof a); }

/// Bit i is set where lane i is true.
ISOCAST_INLINE unsigned bits(const Mask& m) {
    unsigned result = 0;
    ISOCAST_PARTS(k) {
#if defined(__AVX512F__)
        result = (unsigned)_mm512_cmplt_epi64_mask((__m512i)m.part[k], _mm512_setzero_si512());
#elif defined(__AVX__)
        result |= (unsigned)_mm256_movemask_pd((__m256d)m.part[k]) << (k * native_lanes);
#else
        for (int i = 0; i < native_lanes; ++i)
            result |= (unsigned)(m.part[k][i] < 0) << (k * native_lanes + i);
#endif
    }
    return result;
}
