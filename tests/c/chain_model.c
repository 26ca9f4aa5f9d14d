/* A stiff chain of n inertias, heavy and light ones in turn, shafts and meshes with gaps between them, a shaft to
 * ground, a swinging torque on the first: the form of a chain that generated code takes, with its tree pattern, by
 * hand.
 *
 * States: twists q_i = phi_i - phi_(i+1), speeds w_i; quadratures: losses of the couplings, then the work of the
 * torque. */
#include "models.h"

#include <stdlib.h>
#include <string.h>

enum { N_VALUES = 3, LENGTH = 0, SWING = 1, STIFFENED = 2 };

/* Columns behind the values: each `length` long. */
enum { INERTIA, INVERSE, STIFFNESS, DAMPING, GAP };

static int length_of(const double *par) {
    return (int)par[LENGTH];
}

static const double *column(const double *par, int which) {
    return par + N_VALUES + which * length_of(par);
}

static int is_mesh(int i, int n) {
    return i % 2 == 1 && i < n - 1;
}

static void prepare(double *par) {
    const int n = length_of(par);
    double *at = par + N_VALUES;
    for (int i = 0; i < n; i++) {
        const int mesh = is_mesh(i, n);
        at[INERTIA * n + i] = i % 2 ? 1e-5 : 1e-2;
        at[INVERSE * n + i] = 1.0 / at[INERTIA * n + i];
        at[STIFFNESS * n + i] = mesh ? 1.5e6 * par[STIFFENED] : 1e4;
        at[DAMPING * n + i] = mesh ? 0.1 * sqrt(1.5e6 * 1e-5) : 1.0;
        at[GAP * n + i] = mesh ? 8e-4 : 0.0;
    }
}

static void start(const double *par, const double *mode, const double *time_terms, double *y) {
    (void)mode;
    (void)time_terms;
    const int n = length_of(par);
    const double *k = column(par, STIFFNESS), *gap = column(par, GAP);
    for (int i = 0; i < n; i++) {
        y[i] = gap[i] + 200.0 / k[i];
    }
}

static void scales(const double *par, double *scale) {
    const int n = length_of(par);
    for (int i = 0; i < 2 * n; i++) {
        scale[i] = i < n ? column(par, GAP)[i] : 0.0;
    }
}

static void time_terms(const double *par, const double *mode, int lanes, const double *t, const double *u,
                       double *time_terms) {
    (void)mode, (void)u;
    for (int l = 0; l < GB_LANES; l++) {
        time_terms[l] = l < lanes ? 200.0 * (1.0 + par[SWING] * sin(125.66370614359172 * t[l])) : 0.0;
    }
}

static inline void rates(const double *restrict par, const double *restrict mode, double torque,
                         const double *restrict y, double *restrict dy, int full) {
    const int n = length_of(par), first = (2 * n + GB_PAD - 1) / GB_PAD * GB_PAD;
    const double *k = column(par, STIFFNESS), *c = column(par, DAMPING), *gap = column(par, GAP);
    const double *inverse = column(par, INVERSE), *w = y + n;
    double before = torque;
    for (int i = 0; i < n; i++) {
        const double slip = w[i] - (i + 1 < n ? w[i + 1] : 0.0);
        const double side = is_mesh(i, n) ? mode[i / 2] : 1.0;
        const double force = k[i] * (side * side * y[i] - side * gap[i]) + c[i] * slip;
        dy[i] = slip;
        dy[n + i] = (before - force) * inverse[i];
        before = force;
        if (full) {
            dy[first + i] = c[i] * slip * slip;
        }
    }
    for (int i = 2 * n; i < first; i++) {
        dy[i] = 0.0;
    }
    if (full) {
        dy[first + n] = torque * w[0];
    }
}

static void rhs(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    rates(par, mode, time_terms[0], y, dy, 0);
}

static void rhs_full(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    rates(par, mode, time_terms[0], y, dy, 1);
}

static void event_functions(const double *par, const double *mode, const double *time_terms, const double *y,
                            double *s) {
    const int n = length_of(par);
    (void)mode, (void)time_terms;
    for (int i = 1; i < n - 1; i += 2) {
        s[i / 2] = y[i];
    }
}

static void directions(const double *par, const double *direction, double *s) {
    event_functions(par, NULL, NULL, direction, s);
}

static void mode_limits(const double *par, const double *mode, double *lo, double *hi) {
    const int n = length_of(par);
    for (int i = 1; i < n - 1; i += 2) {
        const double gap = column(par, GAP)[i], side = mode[i / 2];
        lo[i / 2] = side > 0.0 ? gap : side < 0.0 ? -HUGE_VAL : -gap;
        hi[i / 2] = side > 0.0 ? HUGE_VAL : side < 0.0 ? -gap : gap;
    }
}

static double mode_at(const double *par, int i, double s) {
    const double gap = column(par, GAP)[2 * i + 1];
    return s >= gap ? 1.0 : s >= -gap ? 0.0 : -1.0;
}

static void outputs(const double *par, const double *mode, const double *time_terms, const double *y, const double *dy,
                    double *out) {
    (void)par, (void)mode, (void)time_terms, (void)y, (void)dy, (void)out;
}

static void energies(const double *par, const double *mode, const double *time_terms, const double *y, double *energy) {
    const int n = length_of(par);
    const double *k = column(par, STIFFNESS), *gap = column(par, GAP), *inertia = column(par, INERTIA);
    (void)time_terms;
    energy[0] = 0.0;
    for (int i = 0; i < n; i++) {
        const double side = is_mesh(i, n) ? mode[i / 2] : 1.0, depth = side * side * y[i] - side * gap[i];
        energy[0] += 0.5 * (k[i] * depth * depth + inertia[i] * y[n + i] * y[n + i]);
    }
}

static void step_matrix(const double *par, const double *mode, const double *time_terms, const double *y,
                        const double *dy, double g, double *diag, double *lower, double *upper, double *kept) {
    const int n = length_of(par);
    const double *k = column(par, STIFFNESS), *c = column(par, DAMPING), *inertia = column(par, INERTIA);
    (void)time_terms, (void)y, (void)dy;
    double before = 0.0;
    for (int i = 0; i < n; i++) {
        const double side = is_mesh(i, n) ? mode[i / 2] : 1.0;
        kept[i] = side * side * k[i];
        const double link = g * (c[i] + g * kept[i]);
        diag[i] = inertia[i] + before + link;
        before = link;
        if (i < n - 1) {
            const int child = i < n / 2 ? i : i + 1;
            const int place = child < n / 2 ? 2 * child : 2 * (n - 1 - child) + 1;
            lower[place] = upper[place] = -link;
        }
    }
}

static void right_side(const double *restrict par, const double *restrict kept, double g, const double *restrict r,
                       double *restrict out) {
    const int n = length_of(par);
    const double *inertia = column(par, INERTIA);
    double before = 0.0;
    for (int i = 0; i < n; i++) {
        const double link = g * kept[i] * r[i];
        out[i] = inertia[i] * r[n + i] + (before - link);
        before = link;
    }
}

static void kinematic_rates(const double *restrict par, const double *restrict kept, const double *restrict x,
                            double *restrict out) {
    const int n = length_of(par);
    (void)kept;
    for (int i = 0; i < n - 1; i++) {
        out[i] = x[i] - x[i + 1];
    }
    out[n - 1] = x[n - 1];
}

/* From both ends to the middle: two eliminations that do not wait for each other. */
static gb_pattern *open_pattern(int n) {
    gb_pattern *p = calloc(1, sizeof *p);
    int *order = calloc((size_t)n, sizeof(int)), *begin = calloc((size_t)n + 1, sizeof(int));
    int *row = calloc((size_t)n, sizeof(int)), *position = calloc((size_t)n, sizeof(int));
    for (int u = 0; u < n; u++) {
        position[u] = u < n / 2 ? 2 * u : 2 * (n - 1 - u) + 1;
    }
    position[n / 2] = n - 1;
    for (int u = 0; u < n; u++) {
        order[position[u]] = u;
    }
    for (int k = 0; k < n; k++) {
        begin[k] = k;
        row[k] = k < n - 1 ? position[order[k] < n / 2 ? order[k] + 1 : order[k] - 1] : 0;
    }
    begin[n] = n - 1;
    free(position);
    p->n = n;
    p->n_places = n - 1;
    p->tree = 1;
    p->order = order;
    p->start = begin;
    p->row = row;
    return p;
}

gb_model *open_chain(int n) {
    const int padded = (2 * n + GB_PAD - 1) / GB_PAD * GB_PAD;
    const gb_model m = {
        .name = "chain",
        .key = "chain",
        .n = 2 * n,
        .n_speeds = n,
        .n_padded = padded,
        .n_quadratures = n + 1,
        .n_total = padded + (n + 1 + GB_PAD - 1) / GB_PAD * GB_PAD,
        .n_parameters = N_VALUES,
        .n_par = N_VALUES + 5 * n,
        .n_time_terms = 1,
        .n_affine = (n - 1) / 2,
        .n_event_functions = (n - 1) / 2,
        .n_switches = (n - 1) / 2,
        .n_energies = 1,
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
        .n_kinematic = n,
        .n_kinematic_terms = n,
        .pattern = open_pattern(n),
        .step_matrix = step_matrix,
        .right_side = right_side,
        .kinematic_rates = kinematic_rates,
    };
    gb_model *out = malloc(sizeof m);
    memcpy(out, &m, sizeof m);
    return out;
}

void close_chain(gb_model *m) {
    free((void *)(size_t)m->pattern->order);
    free((void *)(size_t)m->pattern->start);
    free((void *)(size_t)m->pattern->row);
    free((void *)(size_t)m->pattern);
    free(m);
}
