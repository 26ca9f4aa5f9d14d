/* The loop over steps, samples and corners; included after located.h. */
#ifndef SOLVE_H
#define SOLVE_H

#include "located.h"

#include <stdint.h>

static real *take(real **at, size_t count) {
    real *block = *at;
    *at += (count + 7) / 8 * 8;
    return block;
}

static real *lay_out(solver *s, const problem *p) {
    const size_t n = (size_t)(DIM(p)), g = (size_t)(GAPS(p));
    const size_t total = (n + 8) * (STAGES + PIECES + 4) + (g + 8) * (STAGES + PIECES + 4);
    real *memory = calloc(total + 64, sizeof(real));
    if (memory == NULL)
        return NULL;
    real *at = (real *)(((uintptr_t)memory + 63) / 64 * 64);
    s->k = take(&at, STAGES * n);
    s->dense = take(&at, PIECES * n);
    s->y = take(&at, n);
    s->y1 = take(&at, n);
    s->w = take(&at, n);
    s->big = take(&at, n);
    s->sk = take(&at, STAGES * g);
    s->poly = take(&at, PIECES * g);
    s->side = take(&at, g);
    s->fresh = take(&at, g);
    s->s0 = take(&at, g);
    s->s1 = take(&at, g);
    return memory;
}

/* Goes on from t + x h, where a gap meets a limit; returns the step size to try next (0: no gap stands there). */
static inline real pass_corner(solver *s, real h, real x, real next) {
    const problem *p = s->p;
    const int old = (int)s->side[0] + 1;
    know_dense(s, h);
    dense_state(s, x, s->y1);
    memcpy(s->y, s->y1, (size_t)(DIM(p)) * sizeof(real));
    s->t += x * h;
    if (change_sides(s) == 0)
        return 0;
    rates(p, s->side, s->t, s->y, s->k);
    s->count.rates++;
    if (GAPS(p) != 1)
        return next;
    const int now = (int)s->side[0] + 1;
    s->remembered[old] = next;
    return s->remembered[now] > 0 ? s->remembered[now] : next;
}

static inline void write_samples(solver *s, real h, real until, int *at, int n_out, const double *t_out, double *out) {
    const problem *p = s->p;
    while (*at < n_out && t_out[*at] <= until) {
        know_dense(s, h);
        dense_state(s, (t_out[*at] - s->t) / h, s->w);
        for (int i = 0; i < DIM(p); i++)
            out[*at * DIM(p) + i] = (double)s->w[i];
        ++*at;
    }
}

/* From start at time 0 through the samples t_out into out (n_out x DIM); scale: smallest magnitude that counts.
 * Returns 0, 1 (no memory) or 2 (step size below rounding). */
static int solve(const problem *p, const double *start, const double *side, const double *scale, double first_step,
                 double rtol, int n_out, const double *t_out, double *out, long *count) {
    solver s = {.p = p, .h = first_step, .rtol = rtol};
    real *memory = lay_out(&s, p);
    if (memory == NULL)
        return 1;
    int at = 0, failed = 0;
    for (int i = 0; i < DIM(p); i++) {
        s.y[i] = start[i];
        s.big[i] = fmax(fabs(s.y[i]), (real)scale[i]);
    }
    for (int i = 0; i < GAPS(p); i++)
        s.side[i] = side[i];
    rates(p, s.side, 0, s.y, s.k);
    while (at < n_out) {
        const real h = s.h, error = attempt(&s, h);
        if (h < 4 * REAL_EPS * s.t || !(error < HUGE_VAL)) {
            failed = 2;
            break;
        }
        const real factor = error > 0 ? (real)0.9 * exp(log(error) / -8) : 6;
        const real next = h * fmin(6, fmax((real)0.2, factor));
        if (error > 1) {
            s.h = next;
            s.count.rejected++;
            continue;
        }
        s.count.steps++;
        const real x = corner(&s, h);
        write_samples(&s, h, s.t + fmin(x, 1) * h, &at, n_out, t_out, out);
        if (x <= 1) {
            s.h = pass_corner(&s, h, x, next);
        } else {
            real *const swap = s.y;
            s.y = s.y1;
            s.y1 = swap;
            memcpy(s.k, s.k + 12 * DIM(p), (size_t)(DIM(p)) * sizeof(real));
            memset(s.fresh, 0, (size_t)(GAPS(p)) * sizeof(real));
            s.t += h;
            s.h = next;
        }
        for (int i = 0; i < DIM(p); i++)
            s.big[i] = fmax(s.big[i], fabs(s.y[i]));
    }
    memcpy(count, &s.count, sizeof s.count);
    free(memory);
    return failed;
}
#endif
