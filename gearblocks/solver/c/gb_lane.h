/* Numbers of several lanes at once: one vector holds the same number of GB_LANE_WIDTH independent runs. Operations are
 * those of the scalar code in the same order, so that a lane has its bits whatever the width of the registers.
 *
 * gb_all: the same number in all lanes (a vector stays as it is); gb_select: by lane one or the other. Functions
 * without a vector form go lane by lane.
 *
 * Knows nothing of models. */
#ifndef GB_LANE_H
#define GB_LANE_H

#include "gb_math.h"
#include "gb_model.h"

#ifdef __GNUC__
#pragma GCC diagnostic ignored "-Wpsabi" /* vectors are passed to inlined functions only */
#endif

/* As wide as a register: compilers take wider vectors apart badly. */
#if defined(__AVX512F__)
enum { GB_LANE_WIDTH = 8 };
#elif defined(__AVX__)
enum { GB_LANE_WIDTH = 4 };
#else
enum { GB_LANE_WIDTH = 2 };
#endif

/* Points side by side, enough to hide how long an operation takes, and in how many vectors; instants in the table of a
 * time term, which lie together, so that what laws read fills the cache and not what only others read. */
enum {
    GB_INSTANTS = GB_LANES,
    GB_LANE_POINTS = 32,
    GB_LANE_VECTORS = GB_LANE_POINTS / GB_LANE_WIDTH,
    GB_LANE_LONGEST = 2048, /* steps of a period that has a table */
    GB_LANE_TABLE = 2 * GB_LANE_LONGEST + 3
};
/* What GB_LANES stands for in the text of the laws: from one time term to the next. */
#define GB_LANES (GB_LANE_TABLE * GB_LANE_VECTORS)

typedef double gb_lane __attribute__((vector_size(GB_LANE_WIDTH * sizeof(double))));
typedef long long gb_lane_bits __attribute__((vector_size(GB_LANE_WIDTH * sizeof(double))));

#define GB_LANE_INLINE static inline __attribute__((always_inline, unused))
#define gb_all(x) ((x) - (gb_lane){0.0})

GB_LANE_INLINE gb_lane gb_select(gb_lane_bits condition, gb_lane one, gb_lane other) {
    return (gb_lane)(((gb_lane_bits)one & condition) | ((gb_lane_bits)other & ~condition));
}

/* Whether a condition holds in any lane. */
GB_LANE_INLINE int gb_any(gb_lane_bits condition) {
    long long found = 0;
    for (int i = 0; i < GB_LANE_WIDTH; i++) {
        found |= condition[i];
    }
    return found != 0;
}

/* The side of a band: 1 where s >= half, 0 where s >= -half, else -1. */
GB_LANE_INLINE gb_lane gb_side(gb_lane s, gb_lane half) {
    const gb_lane_bits above = s >= half, inside = s >= -half;
    return (gb_lane)((above & (gb_lane_bits)gb_all(1.0)) | (~inside & (gb_lane_bits)gb_all(-1.0)));
}

GB_LANE_INLINE gb_lane gb_lane_fabs(gb_lane x) {
    return (gb_lane)((gb_lane_bits)x & 0x7fffffffffffffffLL);
}

#define GB_LANE_EACH(name)                                                                                             \
    GB_LANE_INLINE gb_lane gb_lane_##name(gb_lane x) {                                                                 \
        for (int i = 0; i < GB_LANE_WIDTH; i++) {                                                                      \
            x[i] = name(x[i]);                                                                                         \
        }                                                                                                              \
        return x;                                                                                                      \
    }

#define GB_LANE_EACH_OF_TWO(name)                                                                                      \
    GB_LANE_INLINE gb_lane gb_lane_##name(gb_lane x, gb_lane y) {                                                      \
        for (int i = 0; i < GB_LANE_WIDTH; i++) {                                                                      \
            x[i] = name(x[i], y[i]);                                                                                   \
        }                                                                                                              \
        return x;                                                                                                      \
    }

GB_LANE_INLINE gb_lane gb_lane_unit_step(gb_lane x) {
    return gb_select(x >= 0.0, gb_all(1.0), gb_all(0.0));
}

GB_LANE_INLINE gb_lane gb_lane_where(gb_lane m, gb_lane x) {
    return gb_select(m > 0.5, x, gb_all(0.0));
}

GB_LANE_EACH(sqrt)
GB_LANE_EACH(exp)
GB_LANE_EACH(log)
GB_LANE_EACH(tan)
GB_LANE_EACH(tanh)
GB_LANE_EACH(asin)
GB_LANE_EACH(acos)
GB_LANE_EACH(sinh)
GB_LANE_EACH(cosh)
GB_LANE_EACH(asinh)
GB_LANE_EACH(acosh)
GB_LANE_EACH(atanh)
GB_LANE_EACH(log1p)
GB_LANE_EACH(expm1)
GB_LANE_EACH(cbrt)
GB_LANE_EACH(erf)
GB_LANE_EACH(erfc)
GB_LANE_EACH(floor)
GB_LANE_EACH(ceil)
GB_LANE_EACH(gb_sin)
GB_LANE_EACH(gb_cos)
GB_LANE_EACH(gb_atan)
GB_LANE_EACH(gb_fraction)
GB_LANE_EACH_OF_TWO(fmax)
GB_LANE_EACH_OF_TWO(fmin)
GB_LANE_EACH_OF_TWO(pow)
GB_LANE_EACH_OF_TWO(atan2)

#define fabs(x) gb_lane_fabs(gb_all(x))
#define gb_unit_step(x) gb_lane_unit_step(gb_all(x))
#define gb_where(m, x) gb_lane_where(gb_all(m), gb_all(x))
#define sqrt(x) gb_lane_sqrt(gb_all(x))
#define exp(x) gb_lane_exp(gb_all(x))
#define log(x) gb_lane_log(gb_all(x))
#define tan(x) gb_lane_tan(gb_all(x))
#define tanh(x) gb_lane_tanh(gb_all(x))
#define asin(x) gb_lane_asin(gb_all(x))
#define acos(x) gb_lane_acos(gb_all(x))
#define sinh(x) gb_lane_sinh(gb_all(x))
#define cosh(x) gb_lane_cosh(gb_all(x))
#define asinh(x) gb_lane_asinh(gb_all(x))
#define acosh(x) gb_lane_acosh(gb_all(x))
#define atanh(x) gb_lane_atanh(gb_all(x))
#define log1p(x) gb_lane_log1p(gb_all(x))
#define expm1(x) gb_lane_expm1(gb_all(x))
#define cbrt(x) gb_lane_cbrt(gb_all(x))
#define erf(x) gb_lane_erf(gb_all(x))
#define erfc(x) gb_lane_erfc(gb_all(x))
#define floor(x) gb_lane_floor(gb_all(x))
#define ceil(x) gb_lane_ceil(gb_all(x))
#define gb_sin(x) gb_lane_gb_sin(gb_all(x))
#define gb_cos(x) gb_lane_gb_cos(gb_all(x))
#define gb_atan(x) gb_lane_gb_atan(gb_all(x))
#define gb_fraction(x) gb_lane_gb_fraction(gb_all(x))
#define fmax(x, y) gb_lane_fmax(gb_all(x), gb_all(y))
#define fmin(x, y) gb_lane_fmin(gb_all(x), gb_all(y))
#define pow(x, y) gb_lane_pow(gb_all(x), gb_all(y))
#define atan2(x, y) gb_lane_atan2(gb_all(x), gb_all(y))

#endif
