/* An undamped oscillator x'' = u - w^2 x, written by hand: state [x, v], parameter w, input u, output and energies. */
#include "gb_model.h"

#include <math.h>

static void prepare(double *par) {
    par[1] = par[0] * par[0];
}

static void start(const double *par, const double *mode, const double *tau, double *y) {
    (void)mode;
    (void)tau;
    (void)par;
    y[0] = 1.0;
    y[1] = 0.0;
}

static void scales(const double *par, double *scale) {
    (void)par;
    scale[0] = scale[1] = 0.0;
}

static void time_terms(const double *par, const double *mode, int lanes, const double *t, const double *u,
                       double *tau) {
    (void)par;
    (void)mode;
    (void)t;
    for (int lane = 0; lane < lanes; lane++)
        tau[lane] = u[lane];
}

static void rhs(const double *par, const double *mode, const double *tau, const double *y, double *dy) {
    (void)mode;
    dy[0] = y[1];
    dy[1] = tau[0] - par[1] * y[0];
}

static void event_functions(const double *par, const double *mode, const double *tau, const double *y, double *s) {
    (void)par;
    (void)mode;
    (void)tau;
    (void)y;
    (void)s;
}

static void directions(const double *par, const double *dir, double *s) {
    (void)par;
    (void)dir;
    (void)s;
}

static void mode_limits(const double *par, const double *mode, double *lo, double *hi) {
    (void)par;
    (void)mode;
    (void)lo;
    (void)hi;
}

static double mode_at(const double *par, int i, double s) {
    (void)par;
    (void)i;
    return s;
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
    (void)par;
    (void)mode;
    (void)tau;
    (void)dy;
    out[0] = y[0];
    out[1] = y[1];
}

static void energies(const double *par, const double *mode, const double *tau, const double *y, double *energy) {
    (void)mode;
    (void)tau;
    energy[0] = 0.5 * y[1] * y[1];
    energy[1] = 0.5 * par[1] * y[0] * y[0];
}

static const gb_model model = {
    .name = "oscillator",
    .key = "oscillator",
    .n = 2,
    .n_padded = GB_PAD,
    .n_quadratures = 0,
    .n_total = GB_PAD,
    .n_parameters = 1,
    .n_par = 2,
    .n_inputs = 1,
    .n_time_terms = 1,
    .n_outputs = 2,
    .n_energies = 2,
    .prepare = prepare,
    .start = start,
    .scales = scales,
    .time_terms = time_terms,
    .rhs = rhs,
    .rhs_full = rhs,
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
