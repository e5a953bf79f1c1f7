// Eight numbers side by side, in as many registers as the instruction set asks for.
//
// Included inside a namespace of its own for each instruction set; knows builtin types only.

#if defined(__AVX512F__)
constexpr int register_bytes = 64;
#elif defined(__AVX__)
constexpr int register_bytes = 32;
#else
constexpr int register_bytes = 16;
#endif
constexpr int lanes = 8;

#define ISOCAST_INLINE inline __attribute__((always_inline))
#define ISOCAST_PARTS(k) for (int k = 0; k < part_count; ++k)

template<class T>
struct IntegerLike;
template<>
struct IntegerLike<double> {
    using Type = long long;
};
template<>
struct IntegerLike<float> {
    using Type = int;
};

template<class T>
constexpr int native_bytes = register_bytes < lanes* int(sizeof(T)) ? register_bytes
                                                                    : lanes* int(sizeof(T));

template<class T>
struct Mask {
    typedef typename IntegerLike<T>::Type Native __attribute__((vector_size(native_bytes<T>)));
    static constexpr int native_lanes = native_bytes<T> / int(sizeof(T));
    static constexpr int part_count = lanes / native_lanes;
    Native part[part_count];

    friend ISOCAST_INLINE Mask operator&(const Mask& a, const Mask& b) {
        Mask result;
        ISOCAST_PARTS(k) result.part[k] = a.part[k] & b.part[k];
        return result;
    }
    friend ISOCAST_INLINE Mask operator|(const Mask& a, const Mask& b) {
        Mask result;
        ISOCAST_PARTS(k) result.part[k] = a.part[k] | b.part[k];
        return result;
    }
};

template<class T>
struct Lanes {
    typedef T Native __attribute__((vector_size(native_bytes<T>)));
    static constexpr int native_lanes = Mask<T>::native_lanes;
    static constexpr int part_count = Mask<T>::part_count;
    Native part[part_count];

    Lanes() = default;
    ISOCAST_INLINE Lanes(T x) { ISOCAST_PARTS(k) part[k] = Native{} + x; }

#define ISOCAST_LANES_OPERATOR(op)                                                                 \
    friend ISOCAST_INLINE Lanes operator op(const Lanes& a, const Lanes& b) {                      \
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
    friend ISOCAST_INLINE Mask<T> operator op(const Lanes& a, const Lanes& b) {                    \
        Mask<T> result;                                                                            \
        ISOCAST_PARTS(k) result.part[k] = a.part[k] op b.part[k];                                  \
        return result;                                                                             \
    }
    ISOCAST_LANES_COMPARISON(<)
    ISOCAST_LANES_COMPARISON(<=)
    ISOCAST_LANES_COMPARISON(==)
#undef ISOCAST_LANES_COMPARISON

    friend ISOCAST_INLINE Lanes select(const Mask<T>& m, const Lanes& a, const Lanes& b) {
        Lanes result;
        ISOCAST_PARTS(k) result.part[k] = m.part[k] ? a.part[k] : b.part[k];
        return result;
    }
    friend ISOCAST_INLINE Lanes min(const Lanes& a, const Lanes& b) {
        return select(a < b, a, b);
    }
    friend ISOCAST_INLINE Lanes max(const Lanes& a, const Lanes& b) {
        return select(b < a, a, b);
    }
    friend ISOCAST_INLINE Lanes sqrt(const Lanes& a) {
        Lanes result;
        ISOCAST_PARTS(k)
        for (int i = 0; i < native_lanes; ++i)
            result.part[k][i] =
                sizeof(T) == 8 ? T(__builtin_sqrt(a.part[k][i])) : T(__builtin_sqrtf(a.part[k][i]));
        return result;
    }
    friend ISOCAST_INLINE T lane(const Lanes& a, int i) {
        return a.part[i / native_lanes][i % native_lanes];
    }
    friend ISOCAST_INLINE void store(T* p, const Lanes& a) {
        __builtin_memcpy(p, &a, sizeof a);
    }
};

template<class T>
ISOCAST_INLINE Lanes<T> load(const T* p) {
    Lanes<T> result;
    __builtin_memcpy(&result, p, sizeof result);
    return result;
}

/// Bit i is set where lane i is true.
template<class T>
ISOCAST_INLINE unsigned bits(const Mask<T>& m) {
    unsigned result = 0;
    for (int k = 0; k < Mask<T>::part_count; ++k) {
#if defined(__AVX__)
        if constexpr (sizeof m.part[0] == 32) {
            const int part = sizeof(T) == 8 ? _mm256_movemask_pd((__m256d)m.part[k])
                                            : _mm256_movemask_ps((__m256)m.part[k]);
            result |= unsigned(part) << k * Mask<T>::native_lanes;
            continue;
        }
#endif
#if defined(__AVX512F__)
        if constexpr (sizeof m.part[0] == 64) {
            result = _mm512_movepi64_mask((__m512i)m.part[k]);
            continue;
        }
#endif
        for (int i = 0; i < Mask<T>::native_lanes; ++i)
            result |= unsigned(m.part[k][i] < 0) << (k * Mask<T>::native_lanes + i);
    }
    return result;
}

/// Rounds to float.
ISOCAST_INLINE void store_floats(float* p, const Lanes<double>& a) {
    constexpr int n = Lanes<double>::native_lanes;
    typedef float Narrow __attribute__((vector_size(n * int(sizeof(float)))));
    for (int k = 0; k < Lanes<double>::part_count; ++k) {
        const Narrow narrow = __builtin_convertvector(a.part[k], Narrow);
        __builtin_memcpy(p + n * k, &narrow, sizeof narrow);
    }
}

/// Of whole numbers.
ISOCAST_INLINE void store_integers(int* p, const Lanes<double>& a) {
    constexpr int n = Lanes<double>::native_lanes;
    typedef int Narrow __attribute__((vector_size(n * int(sizeof(int)))));
    for (int k = 0; k < Lanes<double>::part_count; ++k) {
        const Narrow narrow = __builtin_convertvector(a.part[k], Narrow);
        __builtin_memcpy(p + n * k, &narrow, sizeof narrow);
    }
}

/// The nearest whole number, of |x| < 2^51; 1.5 * 2^52 leaves no fraction to what is added to it.
ISOCAST_INLINE Lanes<double> rounded(const Lanes<double>& x) {
    constexpr double magic = 0x1.8p52;
    return x + magic - magic;
}
ISOCAST_INLINE Lanes<double> ceiling(const Lanes<double>& x) {
    const Lanes<double> near = rounded(x);
    return near + select(near < x, Lanes<double>(1.0), Lanes<double>(0.0));
}
ISOCAST_INLINE Lanes<double> floor_of(const Lanes<double>& x) {
    const Lanes<double> near = rounded(x);
    return near - select(x < near, Lanes<double>(1.0), Lanes<double>(0.0));
}

/// With the sign turned of lane i where bit i is set.
ISOCAST_INLINE Lanes<float> negated(const Lanes<float>& a, unsigned which) {
    using Native = Mask<float>::Native;
    Lanes<float> result;
    for (int k = 0; k < Mask<float>::part_count; ++k) {
        Native bit;
        for (int i = 0; i < Mask<float>::native_lanes; ++i)
            bit[i] = 1 << (k * Mask<float>::native_lanes + i);
        const Native is_set = (bit & int(which)) != 0;
        result.part[k] = (Lanes<float>::Native)((Native)a.part[k] ^ (is_set & (-2147483647 - 1)));
    }
    return result;
}

template<int... j>
struct Indices {};

/// Exchanges lanes j with bit `s` set of `a` for those without it of `b`.
template<int s, int... j>
ISOCAST_INLINE void exchange(Lanes<double>::Native& a, Lanes<double>::Native& b, Indices<j...>) {
    constexpr int n = sizeof...(j);
    const auto first = __builtin_shufflevector(a, b, (j & s ? n + j - s : j)...);
    b = __builtin_shufflevector(a, b, (j & s ? n + j : j + s)...);
    a = first;
}
template<int s>
ISOCAST_INLINE void exchange(Lanes<double>::Native& a, Lanes<double>::Native& b) {
    if constexpr (Lanes<double>::native_lanes == 8)
        exchange<s>(a, b, Indices<0, 1, 2, 3, 4, 5, 6, 7>());
    else if constexpr (Lanes<double>::native_lanes == 4)
        exchange<s>(a, b, Indices<0, 1, 2, 3>());
    else
        exchange<s>(a, b, Indices<0, 1>());
}

/// Lane j of row i becomes lane i of row j.
ISOCAST_INLINE void transpose(Lanes<double> (&rows)[lanes]) {
    constexpr int n = Lanes<double>::native_lanes;
    constexpr int parts = Lanes<double>::part_count;
    // Squares of n x n, each within itself; then they change places.
    for (int part = 0; part < parts; ++part) {
        for (int i = 0; i < lanes; ++i)
            if (!(i & 1)) exchange<1>(rows[i].part[part], rows[i + 1].part[part]);
        if constexpr (n > 2)
            for (int i = 0; i < lanes; ++i)
                if (!(i & 2)) exchange<2>(rows[i].part[part], rows[i + 2].part[part]);
        if constexpr (n > 4)
            for (int i = 0; i < lanes; ++i)
                if (!(i & 4)) exchange<4>(rows[i].part[part], rows[i + 4].part[part]);
    }
    for (int i = 0; i < lanes; ++i) {
        for (int part = i / n + 1; part < parts; ++part) {
            auto& other = rows[part * n + i % n].part[i / n];
            const auto first = rows[i].part[part];
            rows[i].part[part] = other;
            other = first;
        }
    }
}

#undef ISOCAST_PARTS
