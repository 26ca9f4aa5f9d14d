/* A hand-written integrator of order 8 with located corners, the peer and the reference of the benchmarks.
 *
 * A problem file defines, before it includes this one,
 *     problem                 its numbers, with the member half_gap
 *     DIM(p), GAPS(p)         numbers of states and of gaps of a const problem *p
 *     rates(p, side, t, y, dy)  the right-hand side on frozen sides (-1, 0, +1 of each gap)
 *     gaps(p, y, s)           the gap coordinates, linear in y
 * Between two corners the right-hand side is smooth: a side changes only where a gap coordinate
 * meets -half_gap or +half_gap, found on the dense output of order 7.
 */
#ifndef LOCATED_H
#define LOCATED_H

#include "dop853.h"
#include "real.h"

#include <stdlib.h>
#include <string.h>

enum { STAGES = 16, PIECES = 7, LANES = 8 };

typedef struct counters {
    long steps, rejected, rates, corners;
} counters;

typedef struct solver {
    const problem *p;
    real t, h, rtol;
    real *k;                   /* slopes, STAGES x DIM */
    real *y, *y1, *w;          /* state, next state, stage */
    real *big;                 /* largest magnitude of each state so far, not below its scale */
    real *side, *fresh;        /* side of each gap; the limit it stands on since the last corner, or 0 */
    real *s0, *s1, *sk, *poly; /* gap coordinates at both ends, of the slopes, dense pieces (PIECES x GAPS) */
    real *dense;               /* dense pieces of the whole state (PIECES x DIM) */
    real remembered[3];        /* step size that worked last on each side, where there is one gap */
    int has_extra, has_dense;
    counters count;
} solver;

#define TERM(j, a) +(real)(a) * k[(j) * n + i]
#define STAGE(row)                                                                                                     \
    do {                                                                                                               \
        for (int i = 0; i < n; i++)                                                                                    \
            s->w[i] = s->y[i] + h * (DOP853_A##row(TERM));                                                             \
        rates(p, s->side, s->t + (real)dop853_c[row] * h, s->w, k + (row) * n);                                        \
    } while (0)

/* One step of size h from (t, y), k[0] given: fills k, y1 and returns the error relative to the tolerance. */
static inline real attempt(solver *s, real h) {
    const problem *p = s->p;
    const int n = DIM(p);
    real *restrict k = s->k;
    STAGE(1);
    STAGE(2);
    STAGE(3);
    STAGE(4);
    STAGE(5);
    STAGE(6);
    STAGE(7);
    STAGE(8);
    STAGE(9);
    STAGE(10);
    STAGE(11);
    real e5 = 0, e3 = 0;
    for (int i = 0; i < n; i++) {
        const real move = DOP853_A12(TERM);
        s->y1[i] = s->y[i] + h * move;
        const real weight = fmax(s->big[i], fabs(s->y1[i]));
        e5 = fmax(e5, fabs(DOP853_E5(TERM)) / weight);
        e3 = fmax(e3, fabs(move - (DOP853_E3(TERM))) / weight);
    }
    rates(p, s->side, s->t + h, s->y1, k + 12 * n);
    s->count.rates += 12;
    s->has_extra = s->has_dense = 0;
    e5 *= fabs(h) / s->rtol;
    e3 *= fabs(h) / s->rtol;
    return e5 > 0 ? e5 * e5 / sqrt(e5 * e5 + (real)0.01 * e3 * e3) : 0;
}

static inline void extra_stages(solver *s, real h) {
    const problem *p = s->p;
    const int n = DIM(p);
    real *restrict k = s->k;
    if (s->has_extra)
        return;
    STAGE(13);
    STAGE(14);
    STAGE(15);
    s->count.rates += 3;
    s->has_extra = 1;
}

/* Pieces f of the nested form y + x (f0 + (1-x) (f1 + x (f2 + (1-x) (f3 + ...)))) from the slopes k of n quantities. */
static inline void pieces(int n, real h, const real *y, const real *y1, const real *restrict k, real *restrict f) {
    for (int i = 0; i < n; i++) {
        const real d = y1[i] - y[i];
        f[i] = d;
        f[n + i] = h * k[i] - d;
        f[2 * n + i] = 2 * d - h * (k[i] + k[12 * n + i]);
        f[3 * n + i] = h * (DOP853_D0(TERM));
        f[4 * n + i] = h * (DOP853_D1(TERM));
        f[5 * n + i] = h * (DOP853_D2(TERM));
        f[6 * n + i] = h * (DOP853_D3(TERM));
    }
}

/* (dense output - start) / x and its slope, for one quantity with pieces f[0], f[n], ... */
static inline void quotient(const real *f, int n, real x, real *value, real *slope) {
    const real z = 1 - x;
    real v = f[6 * n], d = 0;
    for (int m = 5; m >= 0; m--) {
        const real q = m % 2 ? x : z;
        d = m % 2 ? v + d * q : d * q - v;
        v = f[m * n] + v * q;
    }
    *value = v;
    *slope = d;
}

/* Distance from one limit, positive inside. A gap that has just left that limit is measured by the quotient. */
typedef struct margin {
    const real *f;
    int n;
    real s0, limit, sign; /* sign (s - limit) >= 0 is inside */
    int fresh;
} margin;

static inline real distance(const margin *m, real x, real *slope) {
    real v, d;
    quotient(m->f, m->n, x, &v, &d);
    *slope = m->sign * (m->fresh ? d : v + x * d);
    return m->sign * (m->fresh ? v : m->s0 + x * v - m->limit);
}

/* Zero of the distance (of its slope when want_slope) in [a, b] by bisection and regula falsi; the signs differ. */
static real bracketed(const margin *m, int want_slope, real a, real b, real fa, real fb) {
    real d;
    int last = 0;
    for (int i = 0; i < 200 && fabs(b - a) > 4 * REAL_EPS * fabs(b); i++) {
        real c = fb != fa ? b - fb * (b - a) / (fb - fa) : (a + b) / 2;
        if (i % 8 == 7 || !(c > fmin(a, b) && c < fmax(a, b)))
            c = (a + b) / 2;
        real fc = distance(m, c, &d);
        if (want_slope)
            fc = d;
        if (fc == 0)
            return c;
        if ((fc > 0) == (fb > 0)) {
            b = c;
            fb = fc;
            if (last == 1)
                fa /= 2;
            last = 1;
        } else {
            a = c;
            fa = fc;
            if (last == -1)
                fb /= 2;
            last = -1;
        }
    }
    return b;
}

/* First x in (0, 1] where the distance becomes negative, or 2. */
static real first_exit(const margin *m) {
    real before, before_slope, value[LANES], slope[LANES];
    before = distance(m, 0, &before_slope);
    for (int i = 0; i < LANES; i++)
        value[i] = distance(m, (real)(i + 1) / LANES, &slope[i]);
    if (before < 0)
        before = 0;
    for (int i = 0; i < LANES; i++) {
        const real a = (real)i / LANES, b = (real)(i + 1) / LANES;
        if (before_slope < 0 && slope[i] > 0) { /* a dip inside this eighth */
            const real x = bracketed(m, 1, a, b, before_slope, slope[i]);
            real d;
            const real low = distance(m, x, &d);
            if (low < 0)
                return bracketed(m, 0, a, x, before, low);
        }
        if (value[i] < 0)
            return bracketed(m, 0, a, b, before, value[i]);
        before = value[i];
        before_slope = slope[i];
    }
    return 2;
}

/* First corner of the step just tried, as a fraction of it, or 2 where there is none. */
static inline real corner(solver *s, real h) {
    const problem *p = s->p;
    const int n = DIM(p), g = GAPS(p);
    const real b = p->half_gap;
    real first = 2;
    gaps(p, s->y, s->s0);
    gaps(p, s->y1, s->s1);
    gaps(p, s->k, s->sk);
    gaps(p, s->k + 12 * n, s->sk + 12 * g);
    int suspicious = 0, poly_known = 0;
    for (int i = 0; i < g; i++) {
        const real reach = fabs(h) * (fabs(s->sk[i]) + fabs(s->sk[12 * g + i]));
        const real side = s->side[i];
        const real above = side > 0 ? s->s0[i] - b : side < 0 ? -b - s->s0[i] : b - fabs(s->s0[i]);
        const real after = side > 0 ? s->s1[i] - b : side < 0 ? -b - s->s1[i] : b - fabs(s->s1[i]);
        suspicious = s->fresh[i] != 0 || fmin(above, after) <= reach;
        if (!suspicious)
            continue;
        if (!poly_known) {
            extra_stages(s, h);
            for (int j = 1; j < STAGES; j++)
                gaps(p, s->k + j * n, s->sk + j * g);
            pieces(g, h, s->s0, s->s1, s->sk, s->poly);
            poly_known = 1;
        }
        margin m = {s->poly + i, g, s->s0[i], 0, 0, 0};
        for (int which = -1; which <= 1; which += 2) { /* the lower limit, the upper limit */
            if (side * which > 0)
                continue;
            m.limit = side > 0 ? b : side < 0 ? -b : which * b;
            m.sign = -which;
            m.fresh = s->fresh[i] == m.limit;
            first = fmin(first, first_exit(&m));
        }
    }
    return first;
}

static inline void know_dense(solver *s, real h) {
    const problem *p = s->p;
    const int n = DIM(p);
    if (s->has_dense)
        return;
    extra_stages(s, h);
    pieces(n, h, s->y, s->y1, s->k, s->dense);
    s->has_dense = 1;
}

static inline void dense_state(const solver *s, real x, real *out) {
    const problem *p = s->p;
    const int n = DIM(p);
    const real z = 1 - x, *f = s->dense;
    for (int i = 0; i < n; i++) {
        real v = f[6 * n + i];
        v = f[5 * n + i] + v * x;
        v = f[4 * n + i] + v * z;
        v = f[3 * n + i] + v * x;
        v = f[2 * n + i] + v * z;
        v = f[n + i] + v * x;
        v = f[i] + v * z;
        out[i] = s->y[i] + x * v;
    }
}

/* Moves every gap that stands on or beyond a limit to its other side; returns how many did. */
static inline int change_sides(solver *s) {
    const problem *p = s->p;
    const real b = p->half_gap;
    int changed = 0;
    gaps(p, s->y, s->s0);
    for (int i = 0; i < GAPS(p); i++) {
        const real side = s->side[i], x = s->s0[i], near = 64 * REAL_EPS * b;
        const real limit = side > 0 ? b : side < 0 ? -b : x > 0 ? b : -b;
        const real inside = side > 0 ? x - b : side < 0 ? -b - x : b - fabs(x);
        s->fresh[i] = 0;
        if (inside > near)
            continue;
        s->side[i] = side != 0 ? 0 : x > 0 ? 1 : -1;
        s->fresh[i] = limit;
        changed++;
    }
    s->count.corners += changed;
    return changed;
}
#endif
