/* Nanoseconds of CPU time per call of a right-hand side, by hand and generated, through the same pointer. */
#define _POSIX_C_SOURCE 200112L
#include "p1_rates.h"

#include <gb_model.h>

#include <math.h>
#include <stdlib.h>
#include <time.h>

const gb_model *gb_get_model(void);

typedef void (*rates_fn)(const double *par, const double *mode, const double *tau, const double *y, double *dy);

enum { ROUNDS = 7, RING = 16, WIDTH = 64 };

/* The smallest of a few rounds over a ring of points, as independent calls: a solver's stage reads the result as a
 * vector, a scalar that waits for it would measure the way from register to memory instead. */
static double per_call(rates_fn rates, const double *par, const double *mode, const double *tau, int n, const double *y,
                       double *dy, int length, long calls) {
    double ring[RING][WIDTH], slopes[RING][WIDTH], best = HUGE_VAL;
    for (int p = 0; p < RING; p++)
        for (int i = 0; i < length; i++)
            ring[p][i] = y[i] * (1.0 + 1e-9 * p);
    for (int round = 0; round < ROUNDS; round++) {
        const clock_t begin = clock();
        for (long i = 0; i < calls; i++)
            rates(par, mode, tau, ring[i % RING], slopes[i % RING]);
        best = fmin(best, (double)(clock() - begin) / CLOCKS_PER_SEC / (double)calls * 1e9);
    }
    for (int i = 0; i < n; i++)
        dy[i] = slopes[0][i];
    return best;
}

static double per_instant(const gb_model *m, const double *par, const double *mode, double *tau, long calls) {
    double t[GB_LANES], best = HUGE_VAL;
    double *inputs = calloc((size_t)m->n_inputs * GB_LANES + 1, sizeof(double));
    if (inputs == NULL)
        return best;
    for (int round = 0; round < ROUNDS; round++) {
        const clock_t begin = clock();
        for (long i = 0; i < calls / GB_LANES; i++) {
            for (int j = 0; j < GB_LANES; j++)
                t[j] = 1e-9 * (double)(i + j);
            m->time_terms(par, mode, GB_LANES, t, inputs, tau);
        }
        best = fmin(best, (double)(clock() - begin) / CLOCKS_PER_SEC / (double)calls * 1e9);
    }
    free(inputs);
    return best;
}

/* out[0]: by hand with cos(w t) given, out[1]: by hand at a time; out[2]: generated rhs, out[3]: rhs_full (with the
 * ledger), out[4]: the time terms per instant, out[5 ..]: generated slopes of the n states at t = 0.
 * dy_hand: the slopes by hand at t = 0. Returns n, or -1 without memory. */
int measure_p1(const double *numbers, const double *y_hand, double *dy_hand, const double *values, long calls,
               double *out) {
    double y8[8], side[1] = {1}, wave[1] = {1}, instant[1] = {0.0137};
    for (int i = 0; i < 8; i++)
        y8[i] = y_hand[i];
    out[1] = per_call(p1_rates_at, numbers, side, instant, 7, y8, dy_hand, 8, calls);
    out[0] = per_call(p1_rates, numbers, side, wave, 7, y8, dy_hand, 8, calls);
    p1_rates(numbers, side, wave, y8, dy_hand);

    const gb_model *m = gb_get_model();
    const size_t lanes = (size_t)(m->n_time_terms + 1) * GB_LANES;
    double *memory = NULL;
    const size_t total = (size_t)(m->n_par + m->n_switches + 2 * m->n_total) + lanes + 64;
    if (posix_memalign((void **)&memory, 64, total * sizeof(double)) != 0)
        return -1;
    for (size_t i = 0; i < total; i++)
        memory[i] = 0;
    double *y = memory, *dy = y + m->n_total, *tau = dy + m->n_total, *mode = tau + lanes;
    double *par = mode + m->n_switches;
    for (int i = 0; i < m->n_parameters; i++)
        par[i] = values[i];
    m->prepare(par);
    for (int i = 0; i < m->n_switches; i++)
        mode[i] = 1; /* the drive side, as by hand */
    out[4] = per_instant(m, par, mode, tau, calls);
    const double now[GB_LANES] = {0};
    m->time_terms(par, mode, 1, now, now, tau);
    m->start(par, mode, tau, y);
    out[2] = per_call(m->rhs, par, mode, tau, m->n, y, dy, m->n_total, calls);
    out[3] = per_call(m->rhs_full, par, mode, tau, m->n, y, dy, m->n_total, calls);
    m->rhs(par, mode, tau, y, dy);
    for (int i = 0; i < m->n; i++)
        out[5 + i] = dy[i];
    free(memory);
    return m->n;
}
