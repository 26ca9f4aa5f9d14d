/* A hand-made gb_model: one inertia on a spring with play, damped, driven by an input and a harmonic torque.
 *
 *     J w' = tau + amplitude cos(speed t) - c w - k g(phi),    g: dead zone of half width half_gap
 *
 * par: J, k, c, half_gap, amplitude, speed, phi0 | 1/J.   y: phi, w | loss, supplied.
 */
#include "gb_model.h"

#include <math.h>
#include <stddef.h>

#include "gb_math.h"

static void prepare(double *par) {
    par[7] = 1.0 / par[0];
}

static void start(const double *par, const double *mode, const double *tau, double *y) {
    (void)mode;
    (void)tau;
    for (int i = 0; i < 16; i++)
        y[i] = 0.0;
    y[0] = par[6];
}

static void scales(const double *par, double *scale) {
    scale[0] = par[3];
    scale[1] = 0.0;
}

static void time_terms(const double *par, const double *mode, int lanes, const double *t, const double *u,
                       double *tau) {
    (void)mode;
    for (int i = 0; i < lanes; i++)
        tau[i] = u[i] + par[4] * gb_cos(par[5] * t[i]);
}

static double spring(const double *par, const double *mode, const double *y) {
    return mode[0] == 0.0 ? 0.0 : par[1] * (y[0] - mode[0] * par[3]);
}

static void rhs(const double *par, const double *mode, const double *tau, const double *y, double *dy) {
    dy[0] = y[1];
    dy[1] = (tau[0] - par[2] * y[1] - spring(par, mode, y)) * par[7];
}

static void rhs_full(const double *par, const double *mode, const double *tau, const double *y, double *dy) {
    rhs(par, mode, tau, y, dy);
    dy[8] = par[2] * y[1] * y[1];
    dy[9] = tau[0] * y[1];
}

static void event_functions(const double *par, const double *mode, const double *tau, const double *y, double *s) {
    (void)par;
    (void)mode;
    (void)tau;
    s[0] = y[0];
}

static void directions(const double *par, const double *dir, double *s) {
    (void)par;
    s[0] = dir[0];
}

static void mode_limits(const double *par, const double *mode, double *lo, double *hi) {
    lo[0] = mode[0] < 0.0 ? -HUGE_VAL : mode[0] > 0.0 ? par[3] : -par[3];
    hi[0] = mode[0] < 0.0 ? -par[3] : mode[0] > 0.0 ? HUGE_VAL : par[3];
}

static double mode_at(const double *par, int i, double s) {
    (void)i;
    return s >= par[3] ? 1.0 : s < -par[3] ? -1.0 : 0.0;
}

static double clock_of(const double *par, int i, double t) {
    (void)par;
    (void)i;
    return t;
}

static double next_time(const double *par, int i, double mode, double t, double *after) {
    (void)par;
    (void)i;
    (void)t;
    *after = mode;
    return HUGE_VAL;
}

static void outputs(const double *par, const double *mode, const double *tau, const double *y, const double *dy,
                    double *out) {
    (void)tau;
    out[0] = y[0];
    out[1] = y[1];
    out[2] = dy[1];
    out[3] = spring(par, mode, y);
    out[4] = mode[0];
}

static void energies(const double *par, const double *mode, const double *tau, const double *y, double *energy) {
    const double torque = spring(par, mode, y);
    (void)tau;
    energy[0] = 0.5 * par[0] * y[1] * y[1];
    energy[1] = 0.5 * torque * torque / par[1];
}

static const gb_model model = {
    .name = "oscillator",
    .key = "oscillator-1",
    .n = 2,
    .n_padded = 8,
    .n_quadratures = 2,
    .n_total = 16,
    .n_parameters = 7,
    .n_par = 8,
    .n_inputs = 1,
    .n_time_terms = 1,
    .n_affine = 1,
    .n_event_functions = 1,
    .n_switches = 1,
    .n_outputs = 5,
    .n_energies = 2,
    .prepare = prepare,
    .start = start,
    .scales = scales,
    .time_terms = time_terms,
    .rhs = rhs,
    .rhs_full = rhs_full,
    .event_functions = event_functions,
    .directions = directions,
    .mode_limits = mode_limits,
    .mode_at = mode_at,
    .time_function = clock_of,
    .next_time = next_time,
    .outputs = outputs,
    .energies = energies,
};

const gb_model *gb_get_model(void);
const gb_model *gb_get_model(void) {
    return &model;
}
