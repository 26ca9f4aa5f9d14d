/* Four discs with a spline-like mesh between the second and the third: problem P1 of the benchmarks.
 *
 * y = [twist of shaft 1, mesh angle, twist of shaft 2 | four speeds | padding | ledger of six entries | padding].
 * The gap is a switch with modes -1, 0, 1; its quantity is the mesh deflection in m.
 */
#include "models.h"

#include "gb_math.h"

enum { N_PADDED = 8, K_MESH = 0, TORQUE, K_RATE };
enum { W = 0, HALF_GAP, T_MEAN, N_GIVEN, C1 = N_GIVEN, C2, C_MESH, N_PAR };

static const double inertia[4] = {5e-3, 2e-4, 2e-4, 1e-2};
static const double inverse[4] = {1 / 5e-3, 1 / 2e-4, 1 / 2e-4, 1 / 1e-2};
static const double k_shaft = 1e5, k_mesh = 245e6, radius = 0.025;

static double damping(double k, double a, double b) {
    return 2.0 * 0.05 * sqrt(k * (a * b / (a + b)));
}

static void prepare(double *par) {
    par[C1] = damping(k_shaft, inertia[0], inertia[1]);
    par[C2] = damping(k_shaft, inertia[2], inertia[3]);
    par[C_MESH] = damping(k_mesh * radius * radius, inertia[1], inertia[2]);
}

static void start(const double *par, const double *mode, const double *time_terms, double *y) {
    (void)mode;
    (void)time_terms;
    for (int i = 0; i < 16; i++) {
        y[i] = 0.0;
    }
    y[0] = y[2] = par[T_MEAN] / k_shaft;
    y[1] = (par[HALF_GAP] + par[T_MEAN] / (radius * k_mesh)) / radius;
}

static void scales(const double *par, double *scale) {
    scale[1] = par[HALF_GAP] / radius;
}

static void time_terms(const double *restrict par, const double *restrict mode, int lanes, const double *restrict t,
                       const double *restrict u, double *restrict time_terms) {
    (void)mode, (void)lanes, (void)u;
    for (int l = 0; l < GB_LANES; l++) {
        const double c = gb_cos(par[W] * t[l]), s = gb_sin(par[W] * t[l]);
        time_terms[K_MESH * GB_LANES + l] = (radius * k_mesh) * (1.0 + 0.3 * c);
        time_terms[TORQUE * GB_LANES + l] = par[T_MEAN] * (1.0 + 0.1 * c);
        time_terms[K_RATE * GB_LANES + l] = -(0.3 * k_mesh) * par[W] * s;
    }
}

/* The dead zone of the deflection r phi on a frozen branch. Few operations lie between phi and the result: a step is
 * a chain of such laws, and its length is what a step costs. */
static inline double closing(double phi, double gap, double mode) {
    return (mode * mode * radius) * phi - mode * gap;
}

typedef double block __attribute__((vector_size(64), aligned(8), may_alias));
static inline void law(const double *restrict par, const double *restrict mode, const double *restrict time_terms,
                       const double *restrict y, double *restrict dy, int full) {
    const double rate1 = y[3] - y[4], rate2 = y[4] - y[5], rate3 = y[5] - y[6];
    const double g = closing(y[1], par[HALF_GAP], mode[0]);
    const double t1 = k_shaft * y[0] + par[C1] * rate1;
    const double t3 = k_shaft * y[2] + par[C2] * rate3;
    const double drag = par[C_MESH] * rate2, t2 = time_terms[K_MESH * GB_LANES] * g;
    *(block *)dy = (block){rate1,
                           rate2,
                           rate3,
                           inverse[0] * (time_terms[TORQUE * GB_LANES] - t1),
                           inverse[1] * ((t1 - drag) - t2),
                           inverse[2] * ((drag - t3) + t2),
                           inverse[3] * (t3 - par[T_MEAN]),
                           0.0};
    if (full) {
        *(block *)(dy + 8) = (block){par[C1] * rate1 * rate1,
                                     par[C_MESH] * rate2 * rate2,
                                     par[C2] * rate3 * rate3,
                                     time_terms[TORQUE * GB_LANES] * y[3],
                                     -par[T_MEAN] * y[6],
                                     0.5 * time_terms[K_RATE * GB_LANES] * g * g,
                                     0.0,
                                     0.0};
    }
}

static void rhs(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    law(par, mode, time_terms, y, dy, 0);
}

static void rhs_full(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    law(par, mode, time_terms, y, dy, 1);
}

static void event_functions(const double *par, const double *mode, const double *time_terms, const double *y,
                            double *s) {
    (void)par, (void)mode, (void)time_terms;
    s[0] = radius * y[1];
}

static void directions(const double *par, const double *dir, double *s) {
    (void)par;
    s[0] = radius * dir[1];
}

static void mode_limits(const double *par, const double *mode, double *lo, double *hi) {
    lo[0] = mode[0] > 0.0 ? par[HALF_GAP] : mode[0] < 0.0 ? -HUGE_VAL : -par[HALF_GAP];
    hi[0] = mode[0] > 0.0 ? HUGE_VAL : mode[0] < 0.0 ? -par[HALF_GAP] : par[HALF_GAP];
}

static double mode_at(const double *par, int i, double s) {
    (void)i;
    return s >= par[HALF_GAP] ? 1.0 : s >= -par[HALF_GAP] ? 0.0 : -1.0;
}

static void outputs(const double *par, const double *mode, const double *time_terms, const double *y, const double *dy,
                    double *out) {
    (void)dy;
    out[0] = radius * y[1];
    out[1] = time_terms[K_MESH * GB_LANES] / radius * closing(y[1], par[HALF_GAP], mode[0]);
}

static void energies(const double *par, const double *mode, const double *time_terms, const double *y, double *energy) {
    const double g = closing(y[1], par[HALF_GAP], mode[0]);
    for (int i = 0; i < 4; i++) {
        energy[i] = 0.5 * inertia[i] * y[3 + i] * y[3 + i];
    }
    energy[4] = 0.5 * k_shaft * y[0] * y[0];
    energy[5] = 0.5 / radius * time_terms[K_MESH * GB_LANES] * g * g;
    energy[6] = 0.5 * k_shaft * y[2] * y[2];
}

const gb_model p1_model = {
    .name = "p1",
    .key = "p1 four discs",
    .n = 7,
    .n_padded = N_PADDED,
    .n_quadratures = 6,
    .n_total = 16,
    .n_parameters = N_GIVEN,
    .n_par = N_PAR,
    .n_time_terms = 3,
    .n_affine = 1,
    .n_event_functions = 1,
    .n_switches = 1,
    .n_outputs = 2,
    .n_energies = 7,
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
const double p1_values[N_GIVEN] = {4.2e4, 20e-6, 2600.0};
