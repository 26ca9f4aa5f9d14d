#include "gb_locate_polynomial.h"
#include "gb_dense_output.h"
#include "gb_modes.h"
#include "gb_vector.h"

/* One polynomial along the step in nested form, and its margin to one limit: margin(th) = start + sign th P(th), or
 * sign P(th) when it is armed there. Negative: the mode has been left. */
typedef struct margin {
    const double *row;
    int stride, rows, armed;
    double start, sign;
} margin;

/* Margin and slope at the eighths, the start first. */
typedef struct margin_samples {
    double value[GB_EIGHTHS + 1], slope[GB_EIGHTHS + 1];
} margin_samples;

static const double eighths[GB_EIGHTHS] = {0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0};

/* P and dP/dth at the eighths. */
static void sample_polynomial(const margin *g, double *restrict p, double *restrict d) {
    for (int l = 0; l < GB_EIGHTHS; l++) {
        p[l] = g->row[(size_t)(g->rows - 1) * (size_t)g->stride];
        d[l] = 0.0;
    }
    for (int m = g->rows - 2; m >= 0; m--) {
        const double r = g->row[(size_t)m * (size_t)g->stride];
        const double offset = m % 2 == 0 ? 1.0 : 0.0, direction = m % 2 == 0 ? -1.0 : 1.0;
        for (int l = 0; l < GB_EIGHTHS; l++) {
            const double factor = offset + direction * eighths[l];
            d[l] = d[l] * factor + direction * p[l];
            p[l] = r + factor * p[l];
        }
    }
}

static double margin_at(const margin *g, double theta, double *slope) {
    double p = g->row[(size_t)(g->rows - 1) * (size_t)g->stride], d = 0.0;
    for (int m = g->rows - 2; m >= 0; m--) {
        const double direction = m % 2 == 0 ? -1.0 : 1.0;
        const double factor = m % 2 == 0 ? 1.0 - theta : theta;
        d = d * factor + direction * p;
        p = g->row[(size_t)m * (size_t)g->stride] + factor * p;
    }
    *slope = g->sign * (g->armed ? d : p + theta * d);
    return g->armed ? g->sign * p : g->start + g->sign * theta * p;
}

static void margin_fill(const margin *g, const double *restrict p, const double *restrict d, margin_samples *out) {
    const double r0 = g->row[0], r1 = g->row[g->stride], r2 = g->row[2 * (size_t)g->stride];
    const double r3 = g->rows > 3 ? g->row[3 * (size_t)g->stride] : 0.0;
    out->value[0] = g->armed ? g->sign * (r0 + r1) : g->start;
    out->slope[0] = g->sign * (g->armed ? (r2 + r3) - r1 : r0 + r1);
    for (int l = 0; l < GB_EIGHTHS; l++) {
        out->value[l + 1] = g->armed ? g->sign * p[l] : g->start + g->sign * eighths[l] * p[l];
        out->slope[l + 1] = g->sign * (g->armed ? d[l] : p[l] + eighths[l] * d[l]);
    }
}

/* The root in [a, b] with margin(a) >= 0 > margin(b): Newton, kept inside by bisection. */
static double margin_root(const margin *g, double a, double b, double fa, double fb, double tolerance) {
    double x = a + (b - a) * (fa / (fa - fb));
    for (int i = 0; i < 80; i++) {
        double slope;
        const double f = margin_at(g, x, &slope);
        if (f < 0.0) {
            b = x;
        } else {
            a = x;
        }
        double next = x - f / slope;
        if (!(next >= a && next <= b)) {
            next = 0.5 * (a + b);
        }
        if (fabs(next - x) <= tolerance || b - a <= tolerance) {
            return next;
        }
        x = next;
    }
    return x;
}

/* The lowest point in [a, b], where the slope turns from negative to positive; stops early below zero. */
static double margin_dip(const margin *g, double a, double b, double da, double db, double tolerance, double *value) {
    double x = a + (b - a) * (da / (da - db));
    for (int i = 0; i < 60; i++) {
        double slope;
        *value = margin_at(g, x, &slope);
        if (*value < 0.0 || slope == 0.0 || b - a <= tolerance) {
            return x;
        }
        if (slope < 0.0) {
            a = x;
            da = slope;
        } else {
            b = x;
            db = slope;
        }
        x = i % 3 == 2 ? 0.5 * (a + b) : a + (b - a) * (da / (da - db));
    }
    return x;
}

/* Could the margin be negative between two samples that are not? The tangents' meeting point, with some room. */
static int may_dip(double width, double fa, double fb, double da, double db) {
    if (!(da < 0.0 && db > 0.0)) {
        return 0;
    }
    const double lowest = (fa * db - fb * da + da * db * width) / (db - da);
    return lowest < 0.1 * width * gb_max(-da, db);
}

/* It is armed on the limit and leaves it no faster than rounding, but bends to the right side, as a slip does after a
 * smooth break-away. */
static int starts_level(const margin *g, const margin_samples *at) {
    double most = 0.0;
    for (int l = 0; l < GB_EIGHTHS; l++) {
        most = gb_max(most, fabs(at->value[l + 1]));
    }
    return g->armed && at->value[0] > -1e-9 * most && at->slope[0] > 0.0;
}

/* An event function that is armed on its limit and beyond it at b may have moved inside first, however shortly: looked
 * for ever closer to the start. Its return, or 0 where it was never inside. */
static double margin_return(const margin *g, double b, double fb, double tolerance) {
    double slope;
    for (double a = 0.25 * b; a > tolerance; a *= 0.25) {
        const double fa = margin_at(g, a, &slope);
        if (fa > 0.0) {
            return margin_root(g, a, b, fa, fb, tolerance);
        }
        b = a;
        fb = fa;
    }
    return 0.0;
}

/* The first theta at which the margin turns negative, or 2. */
static double margin_first(const margin *g, const margin_samples *at, double tolerance) {
    const double width = 1.0 / GB_EIGHTHS;
    if (g->armed && at->slope[0] > 0.0 && at->value[1] < 0.0) {
        const double back = margin_return(g, width, at->value[1], tolerance);
        if (back > 0.0) {
            return back;
        }
    }
    if (at->value[0] < 0.0 && !starts_level(g, at)) {
        return 0.0;
    }
    for (int l = 0; l < GB_EIGHTHS; l++) {
        const double a = (double)l * width, b = a + width;
        if (at->value[l + 1] < 0.0) {
            return margin_root(g, a, b, at->value[l], at->value[l + 1], tolerance);
        }
        if (may_dip(width, at->value[l], at->value[l + 1], at->slope[l], at->slope[l + 1])) {
            double lowest;
            const double dip = margin_dip(g, a, b, at->slope[l], at->slope[l + 1], tolerance, &lowest);
            if (lowest < 0.0) {
                return margin_root(g, a, dip, at->value[l], lowest, tolerance);
            }
        }
    }
    return 2.0;
}

/* A margin that starts negative on its limit counts only when it moves away by more than rounding. */
static int moves_away(const margin_samples *at, double rounding) {
    for (int l = 0; l < GB_EIGHTHS; l++) {
        if (eighths[l] * at->value[l + 1] < -rounding) {
            return 1;
        }
    }
    return 0;
}

/* When switch i leaves through its limit `side` (-1 lower, 1 upper). */
static double first_through(gb_sim *sim, int i, double side, const double *p, const double *d, double tolerance) {
    const double limit = side < 0.0 ? sim->events.lo[i] : sim->events.hi[i], s = sim->events.s0[i];
    margin g = {sim->events.slopes + i, sim->model->n_affine, sim->method->rows, 0, 0.0, -side};
    margin_samples at;
    if (fabs(limit) >= HUGE_VAL) {
        return 2.0;
    }
    const double rounding = gb_limit_rounding(sim, i, limit);
    g.start = side < 0.0 ? s - limit : limit - s;
    g.armed = sim->events.armed[i] == side || g.start <= rounding;
    margin_fill(&g, p, d, &at);
    if (g.armed && (at.value[0] < 0.0 || sim->events.flips[i] > 1.0) && !moves_away(&at, rounding)) {
        return 2.0;
    }
    return margin_first(&g, &at, tolerance);
}

static void watch_affine(gb_sim *sim, int i, double tolerance) {
    const margin g = {sim->events.slopes + i, sim->model->n_affine, sim->method->rows, 0, 0.0, 1.0};
    double p[GB_EIGHTHS], d[GB_EIGHTHS];
    sample_polynomial(&g, p, d);
    const double low = first_through(sim, i, -1.0, p, d, tolerance);
    const double high = first_through(sim, i, 1.0, p, d, tolerance);
    sim->events.located[i] = gb_min(low, high);
    sim->events.side[i] = low < high ? -1.0 : 1.0;
}

/* No limit is near, judged by the cubic rows: the others may add a quarter of what bends the cubic. */
static int is_far(const gb_sim *sim, int i) {
    const int n = sim->model->n_affine;
    const double s0 = sim->events.s0[i], r0 = sim->events.slopes[i], r1 = sim->events.slopes[n + i],
                 r2 = sim->events.slopes[2 * n + i];
    const double bend = 0.25 * (fabs(r1) + fabs(r2)), lo = sim->events.lo[i] + bend, hi = sim->events.hi[i] - bend;
    if (gb_min(s0, s0 + r0) > lo + bend && gb_max(s0, s0 + r0) < hi - bend && sim->events.armed[i] == 0.0) {
        return 1; /* so far from the chord does no point of the cubic lie */
    }
    double outside = s0 < lo || s0 > hi || sim->events.armed[i] != 0.0 ? 1.0 : 0.0;
    for (int l = 0; l < GB_EIGHTHS; l++) {
        const double up = eighths[l], s = s0 + up * (r0 + (1.0 - up) * (r1 + up * r2));
        outside = s < lo || s > hi ? 1.0 : outside;
    }
    return outside == 0.0;
}

static void directions_along(gb_sim *sim, int from, int to) {
    for (int m = from; m < to; m++) {
        sim->model->directions(sim->par, sim->rows + (size_t)m * (size_t)sim->model->n_total,
                               sim->events.slopes + (size_t)m * (size_t)sim->model->n_affine);
    }
}

int gb_locate_affine(gb_sim *sim, double tolerance) {
    const int n = sim->model->n_affine;
    int complete = 0;
    gb_dense_hermite(sim);
    directions_along(sim, 0, 3);
    for (int i = 0; i < n; i++) {
        sim->events.located[i] = 2.0;
        if (is_far(sim, i)) {
            continue;
        }
        if (!complete) {
            if (gb_dense_complete(sim) != GB_DONE) {
                return sim->head->report.code;
            }
            directions_along(sim, 3, sim->method->rows);
            complete = 1;
        }
        watch_affine(sim, i, tolerance);
    }
    return GB_DONE;
}
