/* Crossings of 0 that time alone gives:
 *     g(t) = rate t + offset,    g(t) = size cos(rate t + phase) + offset.
 * Neither the side of a wave at t nor its next crossing is read off a value of g, which near 0 is rounding: both follow
 * from its roots x = +-acos(-offset/size) + 2 pi n in the phase x. Just after t it is on the side that its next root
 * leaves. Roots closer together than phases can be told are a touch, and a touch is no crossing.
 * Knows nothing of models. */
#ifndef GB_TIMED_CROSSING_H
#define GB_TIMED_CROSSING_H

#include "gb_math.h"

#include <float.h>

/* Next instant > t at which rate * t + offset changes to the other sign than `mode` names. */
static inline double gb_line_next(double rate, double offset, double mode, double t, double *after) {
    const double next = -offset / rate;
    *after = 1.0 - mode;
    return (mode > 0.5 ? rate < 0.0 : rate > 0.0) && next > t ? next : HUGE_VAL;
}

/* How finely a phase can be told at t. */
static inline double gb_wave_rounding(double rate, double phase, double t) {
    return 16.0 * DBL_EPSILON * (fabs(rate * t) + fabs(phase) + 6.3);
}

/* It crosses 0 and does not touch it only, by more than the rounding of sizes and phases. */
static inline int gb_wave_crosses(double size, double rate, double phase, double offset, double t) {
    const int passes = rate != 0.0 && fabs(offset) < (1.0 - 4.0 * DBL_EPSILON) * fabs(size);
    return passes && acos(fabs(offset / size)) > gb_wave_rounding(rate, phase, t);
}

/* Next instant > t, by more than its rounding, at which it changes to the other sign than `mode` names. */
static inline double gb_wave_next(double size, double rate, double phase, double offset, double mode, double t,
                                  double *after) {
    *after = 1.0 - mode;
    if (!gb_wave_crosses(size, rate, phase, offset, t))
        return HUGE_VAL;
    /* size cos falls through -offset at +acos (size > 0, rising phase), rises at -acos */
    double root = acos(-offset / size);
    if ((mode > 0.5) != ((size > 0.0) == (rate > 0.0)))
        root = -root;
    const double period = 6.283185307179586476925 / fabs(rate);
    const double soonest = t + gb_wave_rounding(rate, phase, t) / fabs(rate);
    double next = (root - phase) / rate;
    next += period * ceil((t - next) / period);
    while (next <= soonest)
        next += period;
    return next;
}

/* A number with its sign just after t. */
static inline double gb_wave_side(double size, double rate, double phase, double offset, double t) {
    double after;
    if (rate == 0.0)
        return size * gb_cos(phase) + offset;
    if (!gb_wave_crosses(size, rate, phase, offset, t))
        return offset;
    const double falls = gb_wave_next(size, rate, phase, offset, 1.0, t, &after);
    return falls < gb_wave_next(size, rate, phase, offset, 0.0, t, &after) ? 1.0 : -1.0;
}

#endif
