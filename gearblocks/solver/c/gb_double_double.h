/* Angles as hi + lo in two doubles:  hi + lo - 2 pi turns  without losing digits. Sums after Knuth 1969 (4.2.2,
 * theorem B), products after Dekker 1971; 2 pi in four parts (Cody and Waite 1980).
 * Assumed: rounding to nearest, no contraction, whole turns below 2^31.
 * Knows nothing of states and steps. */
#ifndef GB_DOUBLE_DOUBLE_H
#define GB_DOUBLE_DOUBLE_H

#include <math.h>

static const double gb_turn = 6.283185307179586476925; /* rad */

/* hi + lo += x, exactly in hi; lo takes the rounding. */
static inline void gb_add_two(double *hi, double *lo, double x) {
    const double sum = *hi + x, part = sum - *hi;
    *lo += (*hi - (sum - part)) + (x - part);
    *hi = sum;
}

/* hi takes what fits of hi + lo, lo keeps the rest. */
static inline void gb_settle_two(double *hi, double *lo) {
    const double sum = *hi + *lo;
    *lo -= sum - *hi;
    *hi = sum;
}

/* a b, in two parts (Dekker 1971: the halves of 26 bits multiply exactly). */
static inline void gb_multiply_two(double a, double b, double *hi, double *lo) {
    const double split = 134217729.0; /* 2^27 + 1 */
    const double wide_a = split * a, a1 = wide_a - (wide_a - a), a2 = a - a1;
    const double wide_b = split * b, b1 = wide_b - (wide_b - b), b2 = b - b1;
    *hi = a * b;
    *lo = ((a1 * b1 - *hi) + a1 * b2 + a2 * b1) + a2 * b2;
}

/* hi + lo -= 2 pi turns. The first three parts of 2 pi have 22 bits: their products are exact for whole turns < 2^31.
 */
static inline void gb_take_turns(double *hi, double *lo, double turns) {
    gb_add_two(hi, lo, -turns * 0x1.921fbp+2);
    gb_add_two(hi, lo, -turns * 0x1.5110bp-20);
    gb_add_two(hi, lo, -turns * 0x1.1846980000000p-42);
    *lo -= turns * 0x1.3198a2e037073p-67;
    gb_settle_two(hi, lo);
}

/* The multiple of `unit` turns next to an angle, in turns. */
static inline double gb_whole_turns(double angle, double unit) {
    return unit * rint(angle / (gb_turn * unit));
}

/* hi + lo -= 2 pi turns a/b: the whole turns apart from the rest of the division, which is exact below 2^53. */
static inline void gb_take_share(double *hi, double *lo, double turns, double a, double b) {
    const double whole = trunc(turns * a / b);
    gb_take_turns(hi, lo, whole);
    gb_add_two(hi, lo, -gb_turn * ((turns * a - whole * b) / b));
    gb_settle_two(hi, lo);
}

#endif
