/* Trains for the implicit method: a nonlinear oscillator of two states of blocks, and a node without inertia. */
#include "models.h"

static void no_values(double *par) {
    (void)par;
}
static void no_scales(const double *par, double *scale) {
    (void)par, (void)scale;
}
static void no_outputs(const double *par, const double *mode, const double *time_terms, const double *y,
                       const double *dy, double *out) {
    (void)par, (void)mode, (void)time_terms, (void)y, (void)dy, (void)out;
}
static void no_energies(const double *par, const double *mode, const double *time_terms, const double *y,
                        double *energy) {
    (void)par, (void)mode, (void)time_terms, (void)y, (void)energy;
}

static void clear(double *dy) {
    for (int i = 0; i < 16; i++) {
        dy[i] = 0.0;
    }
}

/* x' = z, z' = stiffness ((1 - x^2) z) - x + cos(5 t) x: van der Pol with a restoring force that swings. */
static void swing_times(const double *par, const double *mode, int lanes, const double *t, const double *u,
                        double *time_terms) {
    (void)par, (void)mode, (void)u;
    for (int l = 0; l < lanes; l++) {
        time_terms[l] = cos(5.0 * t[l]);
    }
}

static void pol_start(const double *par, const double *mode, const double *time_terms, double *y) {
    (void)mode;
    (void)time_terms;
    (void)par;
    y[0] = 2.0;
    y[1] = -0.5;
}

static void pol_rhs(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    (void)mode;
    clear(dy);
    dy[0] = y[1];
    dy[1] = par[0] * ((1.0 - y[0] * y[0]) * y[1]) + (time_terms[0] - 1.0) * y[0];
    dy[8] = y[0] * y[1];
}

static const int two_order[] = {0, 1}, two_start[] = {0, 1, 1}, two_row[] = {1};
static const gb_pattern two_pattern = {2, 1, 0, 0, two_order, two_start, two_row, NULL};

static void pol_jacobian(const double *par, const double *mode, const double *time_terms, const double *y,
                         const double *dy, double g, double *diag, double *lower, double *upper, double *kept) {
    (void)mode, (void)dy, (void)kept;
    diag[0] = 1.0;
    upper[0] = -g;
    lower[0] = -g * (-2.0 * par[0] * y[0] * y[1] + time_terms[0] - 1.0);
    diag[1] = 1.0 - g * par[0] * (1.0 - y[0] * y[0]);
}

static void pol_side(const double *par, const double *kept, double g, const double *r, double *out) {
    (void)par, (void)kept, (void)g;
    out[0] = r[0];
    out[1] = r[1];
}

static void no_rates(const double *par, const double *kept, const double *x, double *out) {
    (void)par, (void)kept, (void)x, (void)out;
}

const gb_model pol_model = {
    .name = "van der Pol",
    .key = "van der Pol",
    .n = 2,
    .n_padded = 8,
    .n_quadratures = 1,
    .n_total = 16,
    .n_parameters = 1,
    .n_par = 1,
    .n_time_terms = 1,
    .prepare = no_values,
    .start = pol_start,
    .scales = no_scales,
    .time_terms = swing_times,
    .rhs = pol_rhs,
    .rhs_full = pol_rhs,
    .outputs = no_outputs,
    .energies = no_energies,
    .pattern = &two_pattern,
    .step_matrix = pol_jacobian,
    .right_side = pol_side,
    .kinematic_rates = no_rates,
};

/* An inertia of 1, a hardening spring to a node without inertia, a damper from there to ground; a swinging torque.
 * States: the twist q and the speed w; massless: the speed v of the node. q' = w - v, w' = cos(5 t) - F, 0 = F - d v,
 * F = q + q^3. */
static void node_start(const double *par, const double *mode, const double *time_terms, double *y) {
    (void)mode;
    (void)time_terms;
    (void)par;
    y[0] = 1.0;
}

static void node_rhs(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    (void)mode;
    clear(dy);
    const double force = y[0] + y[0] * y[0] * y[0], node = force / par[0];
    dy[0] = y[1] - node;
    dy[1] = time_terms[0] - force;
    dy[8] = par[0] * node * node;
    dy[9] = time_terms[0] * y[1];
}

static void node_jacobian(const double *par, const double *mode, const double *time_terms, const double *y,
                          const double *dy, double g, double *diag, double *lower, double *upper, double *kept) {
    (void)mode, (void)time_terms, (void)dy;
    const double k = 1.0 + 3.0 * y[0] * y[0];
    kept[0] = k;
    diag[0] = 1.0 + g * g * k;
    diag[1] = g * par[0] + g * g * k;
    lower[0] = upper[0] = -g * g * k;
}

static void node_side(const double *par, const double *kept, double g, const double *r, double *out) {
    (void)par;
    out[0] = r[1] - g * kept[0] * r[0];
    out[1] = g * kept[0] * r[0];
}

static void node_rates(const double *par, const double *kept, const double *x, double *out) {
    (void)par, (void)kept;
    out[0] = x[0] - x[1];
}

static void node_energies(const double *par, const double *mode, const double *time_terms, const double *y,
                          double *energy) {
    (void)par, (void)mode, (void)time_terms;
    energy[0] = 0.5 * (y[1] * y[1] + y[0] * y[0]) + 0.25 * y[0] * y[0] * y[0] * y[0];
}

static const int node_order[] = {1, 0};
static const gb_pattern node_pattern = {2, 1, 1, 0, node_order, two_start, two_row, NULL};

const gb_model node_model = {
    .name = "node",
    .key = "node",
    .n = 2,
    .n_speeds = 1,
    .n_padded = 8,
    .n_quadratures = 2,
    .n_total = 16,
    .n_parameters = 1,
    .n_par = 1,
    .n_time_terms = 1,
    .n_energies = 1,
    .prepare = no_values,
    .start = node_start,
    .scales = no_scales,
    .time_terms = swing_times,
    .rhs = node_rhs,
    .rhs_full = node_rhs,
    .outputs = no_outputs,
    .energies = node_energies,
    .n_kinematic = 1,
    .n_massless = 1,
    .n_kinematic_terms = 1,
    .pattern = &node_pattern,
    .step_matrix = node_jacobian,
    .right_side = node_side,
    .kinematic_rates = node_rates,
};
