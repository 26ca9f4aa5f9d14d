/* Trains of one or two states, each for one property of the solver. */
#include "models.h"

#include <string.h>

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

static void start_at(const double *par, const double *mode, const double *time_terms, double *y) {
    (void)mode;
    (void)time_terms;
    for (int i = 0; i < 16; i++) {
        y[i] = 0.0;
    }
    y[0] = par[0];
}

static void clear(double *dy) {
    for (int i = 0; i < 16; i++) {
        dy[i] = 0.0;
    }
}

/* A relay that drives its state back to the switching point: nothing but chatter from there on. y' = -mode. */
static void relay_rhs(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    (void)par, (void)time_terms, (void)y;
    clear(dy);
    dy[0] = -mode[0];
}

static void state_event_function(const double *par, const double *mode, const double *time_terms, const double *y,
                                 double *s) {
    (void)par, (void)mode, (void)time_terms;
    s[0] = y[0];
}

static void state_direction(const double *par, const double *dir, double *s) {
    (void)par;
    s[0] = dir[0];
}

static void sign_bounds(const double *par, const double *mode, double *lo, double *hi) {
    (void)par;
    lo[0] = mode[0] > 0.0 ? 0.0 : -HUGE_VAL;
    hi[0] = mode[0] > 0.0 ? HUGE_VAL : 0.0;
}

static double sign_mode(const double *par, int i, double s) {
    (void)par, (void)i;
    return s >= 0.0 ? 1.0 : -1.0;
}

const gb_model relay_model = {
    .name = "relay",
    .key = "relay",
    .n = 1,
    .n_padded = 8,
    .n_total = 16,
    .n_parameters = 1,
    .n_par = 1,
    .n_affine = 1,
    .n_event_functions = 1,
    .n_switches = 1,
    .prepare = no_values,
    .start = start_at,
    .scales = no_scales,
    .rhs = relay_rhs,
    .rhs_full = relay_rhs,
    .event_functions = state_event_function,
    .directions = state_direction,
    .mode_limits = sign_bounds,
    .mode_at = sign_mode,
    .outputs = no_outputs,
    .energies = no_energies,
};

/* y' = u + 0 y: the integral of an input. */
static void input_times(const double *par, const double *mode, int lanes, const double *t, const double *u,
                        double *time_terms) {
    (void)par, (void)mode, (void)lanes, (void)t;
    for (int l = 0; l < GB_LANES; l++) {
        time_terms[l] = u[l];
    }
}

static void input_rhs(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    (void)par, (void)mode, (void)y;
    clear(dy);
    dy[0] = time_terms[0];
}

const gb_model input_model = {
    .name = "input",
    .key = "input",
    .n = 1,
    .n_padded = 8,
    .n_total = 16,
    .n_parameters = 1,
    .n_par = 1,
    .n_inputs = 1,
    .n_time_terms = 1,
    .prepare = no_values,
    .start = start_at,
    .scales = no_scales,
    .time_terms = input_times,
    .rhs = input_rhs,
    .rhs_full = input_rhs,
    .outputs = no_outputs,
    .energies = no_energies,
};

/* A square wave of time: y' = mode, which is 1 in [0, 0.3), -1 in [0.3, 0.6) and so on. */
static double wave_clock(const double *par, int i, double t) {
    const double phase = t / 0.3 - 2.0 * floor(t / 0.6);
    (void)par, (void)i;
    return 1.0 - phase;
}

static double wave_next(const double *par, int i, double mode, double t, double *after) {
    double count = floor(t / 0.3);
    (void)par, (void)i;
    while (count * 0.3 <= t) {
        count += 1.0;
    }
    *after = -mode;
    return count * 0.3;
}

const gb_model wave_model = {
    .name = "wave",
    .key = "wave",
    .n = 1,
    .n_padded = 8,
    .n_total = 16,
    .n_parameters = 1,
    .n_par = 1,
    .n_switches = 1,
    .prepare = no_values,
    .start = start_at,
    .scales = no_scales,
    .rhs = relay_rhs,
    .rhs_full = relay_rhs,
    .mode_limits = sign_bounds,
    .mode_at = sign_mode,
    .time_function = wave_clock,
    .next_time = wave_next,
    .outputs = no_outputs,
    .energies = no_energies,
};

/* x'' = -x with an event function that is not affine: x^2 - par[1]; the quadrature integrates its mode. */
static void ring_rhs(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    (void)par, (void)time_terms;
    clear(dy);
    dy[0] = y[1];
    dy[1] = -y[0];
    dy[8] = mode[0];
}

static void ring_event_function(const double *par, const double *mode, const double *time_terms, const double *y,
                                double *s) {
    (void)mode, (void)time_terms;
    s[0] = y[0] * y[0] - par[1];
}

const gb_model ring_model = {
    .name = "ring",
    .key = "ring",
    .n = 2,
    .n_padded = 8,
    .n_quadratures = 1,
    .n_total = 16,
    .n_parameters = 2,
    .n_par = 2,
    .n_event_functions = 1,
    .n_switches = 1,
    .prepare = no_values,
    .start = start_at,
    .scales = no_scales,
    .rhs = ring_rhs,
    .rhs_full = ring_rhs,
    .event_functions = ring_event_function,
    .mode_limits = sign_bounds,
    .mode_at = sign_mode,
    .outputs = no_outputs,
    .energies = no_energies,
};

/* Eight oscillators x'' = 0.1 - 0.1 x' - g(x) with equal gaps +-1, x in y[0 .. 8), x' in y[8 .. 16). */
static void start_eight(const double *par, const double *mode, const double *time_terms, double *y) {
    (void)mode;
    (void)time_terms;
    for (int i = 0; i < 16; i++) {
        y[i] = i < 8 ? par[0] : 0.5;
    }
}

static void eight_rhs(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    (void)par, (void)time_terms;
    for (int i = 0; i < 8; i++) {
        dy[i] = y[8 + i];
        dy[8 + i] = 0.1 - 0.02 * y[8 + i] - (mode[i] * mode[i] * y[i] - mode[i]);
    }
}

static void eight_event_functions(const double *par, const double *mode, const double *time_terms, const double *y,
                                  double *s) {
    (void)par, (void)mode, (void)time_terms;
    memcpy(s, y, 8 * sizeof(double));
}

static void eight_directions(const double *par, const double *dir, double *s) {
    (void)par;
    memcpy(s, dir, 8 * sizeof(double));
}

static void gap_bounds(const double *par, const double *mode, double *lo, double *hi) {
    (void)par;
    for (int i = 0; i < 8; i++) {
        lo[i] = mode[i] > 0.0 ? 1.0 : mode[i] < 0.0 ? -HUGE_VAL : -1.0;
        hi[i] = mode[i] > 0.0 ? HUGE_VAL : mode[i] < 0.0 ? -1.0 : 1.0;
    }
}

static double gap_mode(const double *par, int i, double s) {
    (void)par, (void)i;
    return s >= 1.0 ? 1.0 : s >= -1.0 ? 0.0 : -1.0;
}

const gb_model eight_model = {
    .name = "eight",
    .key = "eight",
    .n = 16,
    .n_padded = 16,
    .n_total = 16,
    .n_parameters = 1,
    .n_par = 1,
    .n_affine = 8,
    .n_event_functions = 8,
    .n_switches = 8,
    .prepare = no_values,
    .start = start_eight,
    .scales = no_scales,
    .rhs = eight_rhs,
    .rhs_full = eight_rhs,
    .event_functions = eight_event_functions,
    .directions = eight_directions,
    .mode_limits = gap_bounds,
    .mode_at = gap_mode,
    .outputs = no_outputs,
    .energies = no_energies,
};

/* y' = y^2: without bound at t = 1 / y(0). */
static void growth_rhs(const double *par, const double *mode, const double *time_terms, const double *y, double *dy) {
    (void)par, (void)mode, (void)time_terms;
    clear(dy);
    dy[0] = y[0] * y[0];
}

const gb_model growth_model = {
    .name = "growth",
    .key = "growth",
    .n = 1,
    .n_padded = 8,
    .n_total = 16,
    .n_parameters = 1,
    .n_par = 1,
    .prepare = no_values,
    .start = start_at,
    .scales = no_scales,
    .rhs = growth_rhs,
    .rhs_full = growth_rhs,
    .outputs = no_outputs,
    .energies = no_energies,
};
