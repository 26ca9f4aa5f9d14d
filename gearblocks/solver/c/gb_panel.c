#include "gb_panel.h"
#include "gb_dense_output.h"
#include "gb_enclosure.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

enum { DEGREE = 8, POINTS = GB_PANEL_POINTS, WIDTH = GB_PAD / 2 }; /* arguments go by blocks of WIDTH */

/* Where the polynomials are fitted, then where they are checked. */
static const double points[POINTS] = {0.0,     0.03125, 0.15625, 0.3125,   0.5,     0.6875,  0.84375,
                                      0.96875, 1.0,     0.09375, 0.234375, 0.40625, 0.765625};

/* Bernstein coefficients 1 to 4 from values at the points of the fit; 8 - i are those of i read backwards, 0 and 8 the
 * values at the ends. */
static const double fit[4][DEGREE + 1] = {
    {-5.033998588030846, 6.876678876678877, -1.3058000822706706, 0.7409897292250234, -0.4696969696969697,
     0.33681351328410153, -0.24181483005012416, 0.22182835086060892, -0.125},
    {11.171270151592733, -18.217282533513973, 13.010241633984949, -8.060272171719417, 5.2702668823880945,
     -3.8317294145492093, 2.769595308632742, -2.5503751676818753, 1.4382853108659561},
    {-14.50278181197536, 24.917070639057325, -23.222129520311338, 24.244886390021776, -18.353313510283208,
     14.179691396199333, -10.549071162547099, 9.871282655634934, -5.585635075796366},
    {11.602225449580288, -20.334877524137124, 20.881896044933477, -26.10603910789905, 28.91359027504482,
     -26.10603910789905, 20.881896044933477, -20.334877524137124, 11.602225449580288},
};

/* All arguments at theta, into x. */
static int arguments_at(gb_sim *sim, double theta, double *x) {
    const gb_head *head = sim->head;
    const double t = head->front.t0 + theta * head->front.h;
    const int code = gb_time_terms_at(sim, t);
    if (code == GB_DONE) {
        gb_dense_states(sim, theta, sim->z2);
        x[0] = t;
        for (int i = 0; i < sim->model->n_inputs; i++) {
            x[1 + i] = sim->instant.u[i * GB_LANES];
        }
        sim->model->arguments(sim->par, sim->mode, sim->instant.time_terms, sim->z2, x);
    }
    return code;
}

/* *least = x where it is less, in each entry; *most = |x| where it is more. */
GB_INLINE void take_lesser(gb_half *least, const gb_half *x) {
    const gb_bits stays = *least < *x;
    *least = (gb_half)((stays & (gb_bits)*least) | (~stays & (gb_bits)*x));
}

GB_INLINE void take_greater(gb_half *most, const gb_half *x) {
    const gb_bits stays = *most > *x;
    *most = (gb_half)((stays & (gb_bits)*most) | (~stays & (gb_bits)*x));
}

GB_INLINE void take_magnitude(gb_half *most, const gb_half *x) {
    gb_half size = *x;
    gb_half_abs(&size);
    take_greater(most, &size);
}

/* *off = value - sum b_i B_i,8(u). */
GB_INLINE void misfit_at(const gb_half *b, double u, const gb_half *value, gb_half *off) {
    gb_half c[DEGREE + 1];
    memcpy(c, b, sizeof c);
    for (int r = 1; r <= DEGREE; r++) {
        for (int i = 0; i <= DEGREE - r; i++) {
            c[i] += u * (c[i + 1] - c[i]);
        }
    }
    *off = *value - c[0];
}

/* Polynomials of the arguments k of one block, what they are off by at points between, and how large they are. Rounding
 * of the values comes out of the fit up to 190 times as large. */
typedef struct fits {
    gb_half size, range, off;
} fits;

static void fit_block(gb_sim *sim, int k, gb_half *b, fits *found) {
    const gb_model *model = sim->model;
    const gb_half none = {0.0};
    const fits nothing = {none, none, none};
    *found = nothing;
    gb_half v[POINTS];
    for (int lane = 0; lane < WIDTH; lane++) {
        const double *values =
            sim->panel.values + model->arguments_read[k + lane < model->n_arguments_read ? k + lane : k];
        for (int l = 0; l < POINTS; l++) {
            v[l][lane] = values[(size_t)l * (size_t)model->n_arguments];
        }
    }
    const gb_half start = v[0];
    for (int l = 0; l < POINTS; l++) {
        take_magnitude(&found->size, &v[l]);
        v[l] -= start;
        take_magnitude(&found->range, &v[l]);
    }
    b[0] = none;
    b[DEGREE] = v[DEGREE];
    for (int i = 1; i <= 4; i++) {
        gb_half forward = none, backward = none;
        for (int l = 0; l <= DEGREE; l++) {
            forward += fit[i - 1][l] * v[l];
            backward += fit[i - 1][l] * v[DEGREE - l];
        }
        b[i] = forward;
        b[DEGREE - i] = i < 4 ? backward : forward;
    }
    for (int l = DEGREE + 1; l < POINTS; l++) {
        gb_half off;
        misfit_at(b, points[l], &v[l], &off);
        take_magnitude(&found->off, &off);
    }
}

/* Whether the polynomial k holds that is off so far. Where half the width left it as far off, that is rounding: of what
 * cancels in an argument that hardly moves (smooth ones come out 500 times closer, beside a corner twice). */
static int holds(gb_sim *sim, int k, double off, double little, int halved) {
    const int is_input = sim->model->arguments_read[k] <= sim->model->n_inputs;
    if (halved && !is_input && off > little && off > 0.7 * sim->panel.misfit[k]) {
        sim->panel.rounding[k] = gb_max(sim->panel.rounding[k], 2.0 * off);
    }
    sim->panel.misfit[k] = off;
    return off <= gb_max(little, sim->panel.rounding[k]);
}

/* The coefficients of a block of arguments. */
static gb_half *block_of(const gb_sim *sim, int first) {
    return (gb_half *)(void *)(sim->panel.bernstein + (size_t)first * (DEGREE + 1));
}

int gb_panel_fill(gb_sim *sim, double from, double to, int halved, int *good) {
    const gb_model *model = sim->model;
    int code = GB_DONE;
    for (int l = 0; l < POINTS && code == GB_DONE; l++) {
        double *x = sim->panel.values + (size_t)l * (size_t)model->n_arguments;
        code = arguments_at(sim, from + points[l] * (to - from), x);
    }
    sim->panel.from = from;
    sim->panel.to = to;
    *good = 1;
    for (int first = 0; first < model->n_arguments_read && code == GB_DONE; first += WIDTH) {
        fits found;
        fit_block(sim, first, block_of(sim, first), &found);
        for (int k = first; k < first + WIDTH && k < model->n_arguments_read; k++) {
            const double size = found.size[k - first], range = found.range[k - first], off = 4.0 * found.off[k - first];
            sim->panel.slack[k] = range == 0.0 ? 0.0 : 1e-13 * size + off;
            *good = holds(sim, k, off, 1e-12 * size + 1e-6 * range, halved) && *good;
        }
    }
    return code;
}

/* The coefficients over [u, v] from those over [0, 1]. */
GB_INLINE void restrict_to(gb_half *c, double u, double v) {
    for (int r = 1; v < 1.0 && r <= DEGREE; r++) {
        for (int i = DEGREE; i >= r; i--) {
            c[i] = c[i - 1] + v * (c[i] - c[i - 1]);
        }
    }
    const double s = u / v;
    for (int r = 1; u > 0.0 && r <= DEGREE; r++) {
        for (int i = 0; i <= DEGREE - r; i++) {
            c[i] += s * (c[i + 1] - c[i]);
        }
    }
}

void gb_panel_piece(gb_sim *sim, double a, double b) {
    const gb_model *model = sim->model;
    const double width = sim->panel.to - sim->panel.from;
    const double u = (a - sim->panel.from) / width, v = gb_min((b - sim->panel.from) / width, 1.0);
    for (int first = 0; first < model->n_arguments_read; first += WIDTH) {
        gb_half c[DEGREE + 1];
        memcpy(c, block_of(sim, first), sizeof c);
        restrict_to(c, u, v);
        gb_half lo = c[0], hi = c[0], down = c[1] - c[0], up = down;
        for (int i = 1; i <= DEGREE; i++) {
            const gb_half rise = c[i] - c[i - 1];
            take_lesser(&lo, &c[i]);
            take_greater(&hi, &c[i]);
            take_lesser(&down, &rise);
            take_greater(&up, &rise);
        }
        for (int k = first; k < first + WIDTH && k < model->n_arguments_read; k++) {
            const int j = model->arguments_read[k], lane = k - first;
            const double start = sim->panel.values[j], slack = sim->panel.slack[k], blur = 16.0 * slack / width;
            const gb_interval value = gb_interval_widened(start + lo[lane] - slack, start + hi[lane] + slack);
            const gb_interval rate = {DEGREE * down[lane] / (b - a) - blur, DEGREE * up[lane] / (b - a) + blur};
            sim->panel.x[j] = gb_enclosed(value, rate);
        }
    }
    const double t0 = sim->head->front.t0, h = sim->head->front.h;
    const gb_interval time = gb_interval_widened(t0 + a * h, t0 + b * h), pace = {h, h};
    sim->panel.x[0] = gb_enclosed(time, pace);
}
