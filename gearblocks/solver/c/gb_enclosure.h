/* Enclosures along a piece of a step: a quantity x(th) lies in [lo, hi], its rate dx/dth in [down, up].
 *
 *     f(x) in f([lo, hi]),   d f(x)/dth in f'([lo, hi]) [down, up]
 *
 * by interval arithmetic (Moore 1966) with rates carried forward (Neidinger 2010). Where a function jumps, its rate is
 * unbounded: with bounded rates a quantity is continuous and differs by no more than they allow.
 * Assumed: round to nearest; every result is widened by a few units in its last place. Numbers that are not known are
 * [-inf, inf].
 * Knows nothing of event functions. */
#ifndef GB_ENCLOSURE_H
#define GB_ENCLOSURE_H

#include "gb_math.h"
#include "gb_table.h"

#include <float.h>

typedef struct gb_interval {
    double lo, hi;
} gb_interval;

typedef struct gb_enclosure {
    double lo, hi, down, up;
} gb_enclosure;

/* -- intervals -- */

/* Outward by a few units in the last place; what is not a number is not known. */
static inline gb_interval gb_interval_widened(double lo, double hi) {
    const gb_interval all = {-HUGE_VAL, HUGE_VAL};
    const gb_interval wide = {lo - 4.0 * DBL_EPSILON * fabs(lo), hi + 4.0 * DBL_EPSILON * fabs(hi)};
    return wide.lo <= wide.hi ? wide : all;
}

/* A function of its arguments alone that is not copied to where it is called: equal calls are made once, and compilers
 * have less to do. */
#if defined(__GNUC__) && defined(__OPTIMIZE__)
#define GB_APART static __attribute__((noinline, const, unused))
#else
#define GB_APART static inline
#endif

/* fmin and fmax, which compilers call from a library: the other number where one is none. */
static inline double gb_lesser(double a, double b) {
    return b < a || a != a ? b : a;
}

static inline double gb_greater(double a, double b) {
    return b > a || a != a ? b : a;
}

/* 0 times what has no bound is 0: it is the product of numbers, not of limits. */
static inline double gb_interval_product(double a, double b) {
    const double product = a * b;
    return product != product && (a == 0.0 || b == 0.0) ? 0.0 : product;
}

static inline gb_interval gb_interval_mul(gb_interval a, gb_interval b) {
    const double ll = gb_interval_product(a.lo, b.lo), lh = gb_interval_product(a.lo, b.hi);
    const double hl = gb_interval_product(a.hi, b.lo), hh = gb_interval_product(a.hi, b.hi);
    return gb_interval_widened(gb_lesser(gb_lesser(ll, lh), gb_lesser(hl, hh)),
                               gb_greater(gb_greater(ll, lh), gb_greater(hl, hh)));
}

static inline gb_interval gb_interval_scale(gb_interval x, double c) {
    const double one = gb_interval_product(x.lo, c), other = gb_interval_product(x.hi, c);
    return c < 0.0 ? gb_interval_widened(other, one) : gb_interval_widened(one, other);
}

static inline gb_interval gb_interval_add(gb_interval a, gb_interval b) {
    return gb_interval_widened(a.lo + b.lo, a.hi + b.hi);
}

static inline gb_interval gb_interval_hull(gb_interval a, gb_interval b) {
    const gb_interval hull = {gb_lesser(a.lo, b.lo), gb_greater(a.hi, b.hi)};
    return hull;
}

/* middle +- reach. */
static inline gb_interval gb_interval_about(double middle, double reach) {
    return gb_interval_widened(middle - reach - 4.0 * DBL_EPSILON * (fabs(middle) + reach),
                               middle + reach + 4.0 * DBL_EPSILON * (fabs(middle) + reach));
}

/* Sine and cosine of one phase. */
typedef struct gb_waves {
    gb_interval sine, cosine;
} gb_waves;

/* A wave with the values a and b at the ends of [from, to] in quarter turns, whose maxima lie at 4 k. Within a few
 * units in the last place, so that its sign near 0 is told however close; far out absolutely: from_zero 1. */
static inline gb_interval gb_interval_wave(double from, double to, double a, double b, double from_zero) {
    const int has_most = floor(0.25 * to) >= ceil(0.25 * from);
    const int has_least = floor(0.25 * (to - 2.0)) >= ceil(0.25 * (from - 2.0));
    const double least = gb_lesser(a, b), most = gb_greater(a, b);
    const gb_interval wave = {has_least ? -1.0 : least - 4.0 * DBL_EPSILON * gb_greater(fabs(least), from_zero),
                              has_most ? 1.0 : most + 4.0 * DBL_EPSILON * gb_greater(fabs(most), from_zero)};
    return wave;
}

GB_APART gb_waves gb_interval_waves(gb_interval x) {
    const gb_waves all = {{-1.0, 1.0}, {-1.0, 1.0}};
    const double quarter = 0.63661977236758134308; /* 2 / pi */
    if (!(x.hi - x.lo < 6.28) || !(fabs(x.lo) < 1e13) || !(fabs(x.hi) < 1e13)) {
        return all;
    }
    const double from = x.lo * quarter * (x.lo > 0.0 ? 1.0 - 1e-15 : 1.0 + 1e-15);
    const double to = x.hi * quarter * (x.hi > 0.0 ? 1.0 + 1e-15 : 1.0 - 1e-15);
    const double from_zero = gb_greater(fabs(x.lo), fabs(x.hi)) < 1e9 ? 0.0 : 1.0;
    const gb_waves waves = {gb_interval_wave(from - 1.0, to - 1.0, gb_sin(x.lo), gb_sin(x.hi), from_zero),
                            gb_interval_wave(from, to, gb_cos(x.lo), gb_cos(x.hi), from_zero)};
    return waves;
}

/* -- arithmetic -- */

static inline gb_interval gb_value_of(gb_enclosure x) {
    const gb_interval value = {x.lo, x.hi};
    return value;
}

static inline gb_interval gb_rate_of(gb_enclosure x) {
    const gb_interval rate = {x.down, x.up};
    return rate;
}

static inline gb_enclosure gb_enclosed(gb_interval value, gb_interval rate) {
    const gb_enclosure x = {value.lo, value.hi, rate.lo, rate.hi};
    return x;
}

/* f(x) from its value and derivative over [lo, hi]. */
static inline gb_enclosure gb_chained(gb_enclosure x, gb_interval value, gb_interval derivative) {
    return gb_enclosed(value, gb_interval_mul(derivative, gb_rate_of(x)));
}

static inline gb_enclosure gb_enclosed_number(double c) {
    const gb_enclosure x = {c, c, 0.0, 0.0};
    return x;
}

static inline gb_enclosure gb_enclosed_shift(gb_enclosure x, double c) {
    return gb_enclosed(gb_interval_widened(x.lo + c, x.hi + c), gb_rate_of(x));
}

static inline gb_enclosure gb_enclosed_scale(gb_enclosure x, double c) {
    return gb_enclosed(gb_interval_scale(gb_value_of(x), c), gb_interval_scale(gb_rate_of(x), c));
}

static inline gb_enclosure gb_enclosed_add(gb_enclosure a, gb_enclosure b) {
    return gb_enclosed(gb_interval_add(gb_value_of(a), gb_value_of(b)), gb_interval_add(gb_rate_of(a), gb_rate_of(b)));
}

static inline gb_enclosure gb_enclosed_mul(gb_enclosure a, gb_enclosure b) {
    const gb_interval left = gb_interval_mul(gb_rate_of(a), gb_value_of(b));
    const gb_interval right = gb_interval_mul(gb_value_of(a), gb_rate_of(b));
    return gb_enclosed(gb_interval_mul(gb_value_of(a), gb_value_of(b)), gb_interval_add(left, right));
}

static inline gb_interval gb_interval_inverse(gb_interval x) {
    return x.lo > 0.0 || x.hi < 0.0 ? gb_interval_widened(1.0 / x.hi, 1.0 / x.lo)
                                    : gb_interval_widened(-HUGE_VAL, HUGE_VAL);
}

/* x^n for n >= 1. */
static inline gb_interval gb_interval_power(gb_interval x, int n) {
    double lo = 1.0, hi = 1.0;
    for (int k = 0; k < n; k++) {
        lo *= x.lo;
        hi *= x.hi;
    }
    const double most = gb_greater(lo, hi), least = n % 2 == 0 && x.lo < 0.0 && x.hi > 0.0 ? 0.0 : gb_lesser(lo, hi);
    const gb_interval value = {least - 4.0 * n * DBL_EPSILON * fabs(least), most + 4.0 * n * DBL_EPSILON * fabs(most)};
    return gb_interval_widened(value.lo, value.hi);
}

/* x^n for any whole n but 0. */
static inline gb_enclosure gb_enclosed_power(gb_enclosure x, int n) {
    const gb_interval at = gb_value_of(x), one = {1.0, 1.0}, size = {n, n};
    if (n < 0 && x.lo <= 0.0 && x.hi >= 0.0) { /* a pole: it jumps from one infinity to the other */
        const gb_interval all = {-HUGE_VAL, HUGE_VAL};
        return gb_enclosed(all, all);
    }
    if (n < 0) {
        const gb_interval inverse = gb_interval_inverse(at);
        return gb_chained(x, gb_interval_power(inverse, -n), gb_interval_mul(size, gb_interval_power(inverse, 1 - n)));
    }
    return gb_chained(x, gb_interval_power(at, n), n == 1 ? one : gb_interval_mul(size, gb_interval_power(at, n - 1)));
}

/* -- functions -- */

/* A function that grows with x throughout: from its values and derivatives at the ends, the larger derivative where
 * `peak` (of even functions that fall on both sides of 0) is passed. */
static inline gb_enclosure gb_enclosed_growing(gb_enclosure x, double a, double b, double da, double db, double peak) {
    const double most = x.lo < 0.0 && x.hi > 0.0 ? fmax(fmax(da, db), peak) : fmax(da, db);
    return gb_chained(x, gb_interval_widened(a - 4.0 * DBL_EPSILON * fabs(a), b + 4.0 * DBL_EPSILON * fabs(b)),
                      gb_interval_widened(fmin(da, db), most));
}

static inline gb_waves gb_enclosed_waves(gb_enclosure x) {
    return gb_interval_waves(gb_value_of(x));
}

static inline gb_enclosure gb_enclosed_sin(gb_enclosure x, gb_waves of_x) {
    return gb_chained(x, of_x.sine, of_x.cosine);
}

static inline gb_enclosure gb_enclosed_cos(gb_enclosure x, gb_waves of_x) {
    const gb_interval slope = {-of_x.sine.hi, -of_x.sine.lo};
    return gb_chained(x, of_x.cosine, slope);
}

static inline gb_enclosure gb_enclosed_tan(gb_enclosure x) {
    const gb_interval c = gb_interval_waves(gb_value_of(x)).cosine, all = {-HUGE_VAL, HUGE_VAL};
    if (!(c.lo > 0.0 || c.hi < 0.0)) {
        return gb_enclosed(all, all);
    }
    const double a = tan(x.lo), b = tan(x.hi);
    return gb_chained(x, gb_interval_about(0.5 * (a + b), 0.5 * (b - a)), gb_interval_power(gb_interval_inverse(c), 2));
}

static inline gb_enclosure gb_enclosed_atan(gb_enclosure x) {
    return gb_enclosed_growing(x, gb_atan(x.lo), gb_atan(x.hi), 1.0 / (1.0 + x.lo * x.lo), 1.0 / (1.0 + x.hi * x.hi),
                               1.0);
}

static inline gb_enclosure gb_enclosed_asin(gb_enclosure x) {
    const double a = fmin(fmax(x.lo, -1.0), 1.0), b = fmin(fmax(x.hi, -1.0), 1.0);
    const double da = 1.0 / sqrt(1.0 - a * a), db = 1.0 / sqrt(1.0 - b * b);
    const gb_interval slope = {a < 0.0 && b > 0.0 ? 1.0 : fmin(da, db), fmax(da, db)};
    return gb_chained(x, gb_interval_widened(asin(a), asin(b)), gb_interval_widened(slope.lo, slope.hi));
}

static inline gb_enclosure gb_enclosed_exp(gb_enclosure x) {
    return gb_enclosed_growing(x, exp(x.lo), exp(x.hi), exp(x.lo), exp(x.hi), 0.0);
}

static inline gb_enclosure gb_enclosed_log(gb_enclosure x) {
    const double lo = fmax(x.lo, 0.0);
    return gb_enclosed_growing(x, log(lo), log(x.hi), 1.0 / lo, 1.0 / x.hi, 0.0);
}

static inline gb_enclosure gb_enclosed_tanh(gb_enclosure x) {
    const double a = tanh(x.lo), b = tanh(x.hi);
    return gb_enclosed_growing(x, a, b, 1.0 - a * a, 1.0 - b * b, 1.0);
}

static inline gb_enclosure gb_enclosed_sinh(gb_enclosure x) {
    const gb_interval slope = {x.lo < 0.0 && x.hi > 0.0 ? 1.0 : fmin(cosh(x.lo), cosh(x.hi)),
                               fmax(cosh(x.lo), cosh(x.hi))};
    return gb_chained(x, gb_interval_widened(sinh(x.lo), sinh(x.hi)), gb_interval_widened(slope.lo, slope.hi));
}

static inline gb_enclosure gb_enclosed_cosh(gb_enclosure x) {
    const gb_interval value = {x.lo < 0.0 && x.hi > 0.0 ? 1.0 : fmin(cosh(x.lo), cosh(x.hi)),
                               fmax(cosh(x.lo), cosh(x.hi))};
    return gb_chained(x, gb_interval_widened(value.lo, value.hi), gb_interval_widened(sinh(x.lo), sinh(x.hi)));
}

/* x^p for x >= 0 and a number p; of p < 0, which falls, without bound where x comes to 0. */
static inline gb_enclosure gb_enclosed_root(gb_enclosure x, double p) {
    const double lo = fmax(x.lo, 0.0), a = pow(lo, p), b = pow(x.hi, p);
    return gb_enclosed_growing(x, fmin(a, b), fmax(a, b), p * pow(lo, p - 1.0), p * pow(x.hi, p - 1.0), 0.0);
}

/* atan2(y, x): its branch cut is a jump. */
static inline gb_enclosure gb_enclosed_atan2(gb_enclosure y, gb_enclosure x) {
    const gb_interval all = {-HUGE_VAL, HUGE_VAL}, round = {-3.1416, 3.1416};
    if (x.lo <= 0.0 && y.lo <= 0.0 && y.hi >= 0.0) {
        return gb_enclosed(round, all);
    }
    gb_interval angle = {HUGE_VAL, -HUGE_VAL};
    for (int corner = 0; corner < 4; corner++) {
        const double at = atan2(corner & 1 ? y.lo : y.hi, corner & 2 ? x.lo : x.hi);
        const gb_interval point = {at, at};
        angle = gb_interval_hull(angle, point);
    }
    const gb_interval back = {-y.hi, -y.lo}, square = gb_interval_add(gb_interval_power(gb_value_of(x), 2),
                                                                      gb_interval_power(gb_value_of(y), 2));
    const gb_interval turn =
        gb_interval_add(gb_interval_mul(gb_value_of(x), gb_rate_of(y)), gb_interval_mul(back, gb_rate_of(x)));
    return gb_enclosed(gb_interval_widened(angle.lo, angle.hi), gb_interval_mul(turn, gb_interval_inverse(square)));
}

/* 1 where x >= 0, else 0. */
static inline gb_enclosure gb_enclosed_heaviside(gb_enclosure x) {
    const gb_enclosure either = {0.0, 1.0, -HUGE_VAL, HUGE_VAL};
    return x.lo >= 0.0 ? gb_enclosed_number(1.0) : (x.hi < 0.0 ? gb_enclosed_number(0.0) : either);
}

/* x where m is 1, else 0. */
static inline gb_enclosure gb_enclosed_where(double m, gb_enclosure x) {
    return m > 0.5 ? x : gb_enclosed_number(0.0);
}

static inline gb_enclosure gb_enclosed_floor(gb_enclosure x) {
    const gb_enclosure step = {floor(x.lo), floor(x.hi), -HUGE_VAL, HUGE_VAL};
    return step.lo == step.hi ? gb_enclosed_number(step.lo) : step;
}

/* x - floor(x). */
static inline gb_enclosure gb_enclosed_fraction(gb_enclosure x) {
    const gb_enclosure step = {0.0, 1.0, -HUGE_VAL, HUGE_VAL};
    return floor(x.lo) == floor(x.hi) ? gb_enclosed_shift(x, -floor(x.lo)) : step;
}

#endif
