/* One gear pair in Kahraman-Singh form: problem P2 of the benchmarks.
 *
 * x'' + 2 z x' + (1 + eps cos w t) g(x) = Fm + Fah w^2 cos w t, the gap being +-1.
 * y = [x, x' | padding | ledger: loss, supplied by the forces, parametric | padding].
 */
#include "models.h"

#include "gb_math.h"

enum { Z = 0, EPS, FM, FAH, W, GAP, N_PAR };

static void prepare(double *par) {
    (void)par;
}

static void start(const double *par, const double *mode, const double *time_terms, double *y) {
    (void)mode;
    (void)time_terms;
    (void)par;
    for (int i = 0; i < 16; i++) {
        y[i] = 0.0;
    }
    y[0] = 1.1;
}

static void scales(const double *par, double *scale) {
    scale[0] = par[GAP];
}

static void time_terms(const double *restrict par, const double *restrict mode, int lanes, const double *restrict t,
                       const double *restrict u, double *restrict time_terms) {
    (void)mode, (void)lanes, (void)u;
    for (int l = 0; l < GB_LANES; l++) {
        const double c = gb_cos(par[W] * t[l]);
        time_terms[l] = 1.0 + par[EPS] * c;
        time_terms[GB_LANES + l] = par[FM] + par[FAH] * par[W] * par[W] * c;
        time_terms[2 * GB_LANES + l] = -par[EPS] * par[W] * gb_sin(par[W] * t[l]);
    }
}

static inline double closing(double x, double gap, double mode) {
    return mode * mode * x - mode * gap;
}

static void rhs(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    dy[0] = y[1];
    dy[1] = time_terms[GB_LANES] - 2.0 * par[Z] * y[1] - time_terms[0] * closing(y[0], par[GAP], mode[0]);
    for (int i = 2; i < 8; i++) {
        dy[i] = 0.0;
    }
}

static void rhs_full(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    const double g = closing(y[0], par[GAP], mode[0]);
    rhs(par, mode, time_terms, y, dy);
    dy[8] = 2.0 * par[Z] * y[1] * y[1];
    dy[9] = time_terms[GB_LANES] * y[1];
    dy[10] = 0.5 * time_terms[2 * GB_LANES] * g * g;
    for (int i = 11; i < 16; i++) {
        dy[i] = 0.0;
    }
}

static void event_functions(const double *par, const double *mode, const double *time_terms, const double *y,
                            double *s) {
    (void)par, (void)mode, (void)time_terms;
    s[0] = y[0];
}

static void directions(const double *par, const double *dir, double *s) {
    (void)par;
    s[0] = dir[0];
}

static void mode_limits(const double *par, const double *mode, double *lo, double *hi) {
    lo[0] = mode[0] > 0.0 ? par[GAP] : mode[0] < 0.0 ? -HUGE_VAL : -par[GAP];
    hi[0] = mode[0] > 0.0 ? HUGE_VAL : mode[0] < 0.0 ? -par[GAP] : par[GAP];
}

static double mode_at(const double *par, int i, double s) {
    (void)i;
    return s >= par[GAP] ? 1.0 : s >= -par[GAP] ? 0.0 : -1.0;
}

static void outputs(const double *par, const double *mode, const double *time_terms, const double *y, const double *dy,
                    double *out) {
    (void)par, (void)mode, (void)time_terms;
    out[0] = y[0];
    out[1] = dy[1];
}

static void energies(const double *par, const double *mode, const double *time_terms, const double *y, double *energy) {
    const double g = closing(y[0], par[GAP], mode[0]);
    energy[0] = 0.5 * y[1] * y[1];
    energy[1] = 0.5 * time_terms[0] * g * g;
}

const gb_model p2_model = {
    .name = "p2",
    .key = "p2 gear pair",
    .n = 2,
    .n_padded = 8,
    .n_quadratures = 3,
    .n_total = 16,
    .n_parameters = N_PAR,
    .n_par = N_PAR,
    .n_time_terms = 3,
    .n_affine = 1,
    .n_event_functions = 1,
    .n_switches = 1,
    .n_outputs = 2,
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
    .outputs = outputs,
    .energies = energies,
};
const double p2_values[N_PAR] = {0.05, 0.2, 0.1, 0.05, 0.9, 1.0};
