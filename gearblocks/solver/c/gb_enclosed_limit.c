#include "gb_enclosed_limit.h"
#include "gb_event_values.h"
#include "gb_force_enclosure.h"
#include "gb_modes.h"
#include "gb_panel.h"
#include "gb_vector.h"

/* Looks over ever shorter pieces from the start, and back from a root. */
enum { LOOKS_AHEAD = 8, LOOKS_BACK = 4 };

/* Part of its fall by which f may rise over the same piece: rounding of the arguments. */
static const double BLUR = 1e-6;

int gb_limits(const gb_model *model) {
    return 2 * (model->n_event_functions - model->n_affine);
}

gb_limit gb_limit_at(const gb_sim *sim, int number) {
    const int i = sim->model->n_affine + number / 2;
    const double side = number % 2 ? 1.0 : -1.0, at = side < 0.0 ? sim->events.lo[i] : sim->events.hi[i];
    const gb_limit found = {i, sim->panel.watched[i] && fabs(at) < HUGE_VAL ? side : 0.0};
    return found;
}

void gb_enclose(gb_sim *sim, int with_forces, double a, double b) {
    gb_panel_piece(sim, a, b);
    sim->model->enclosures(sim->par, sim->mode, sim->panel.x, sim->panel.enclosure);
    if (with_forces) {
        gb_forces_enclose(sim);
    }
}

gb_interval gb_margin(const gb_sim *sim, gb_limit at) {
    const gb_enclosure *g = &sim->panel.enclosure[at.i];
    const gb_interval f = {gb_limit_distance(sim, at.i, at.side, at.side < 0.0 ? g->lo : g->hi),
                           gb_limit_distance(sim, at.i, at.side, at.side < 0.0 ? g->hi : g->lo)};
    return f;
}

gb_interval gb_margin_rate(const gb_sim *sim, gb_limit at) {
    const gb_enclosure *g = &sim->panel.enclosure[at.i];
    const gb_interval rate = {at.side < 0.0 ? g->down : -g->up, at.side < 0.0 ? g->up : -g->down};
    return rate;
}

static double start_distance(const gb_sim *sim, gb_limit at) {
    return gb_limit_distance(sim, at.i, at.side, sim->events.s0[at.i]);
}

double gb_margin_rounding(const gb_sim *sim, gb_limit at) {
    const double rounding = gb_limit_rounding(sim, at.i, 0.0);
    return sim->events.role[at.i] == GB_ORDINARY ? gb_min(rounding, sim->panel.far) : rounding;
}

int gb_starts_on_limit(const gb_sim *sim, gb_limit at) {
    return start_distance(sim, at) == 0.0;
}

/* Nothing else has decided about its side: no flip, no switched constraint. */
static int is_open(const gb_sim *sim, gb_limit at) {
    return sim->events.armed[at.i] != at.side && sim->events.role[at.i] != GB_CONSTRAINED;
}

/* sign f rises over [0, b], beside whose rise its fall is rounding, and does not fall at all towards b. */
static int goes(gb_sim *sim, int with_forces, gb_limit at, double sign, double b) {
    gb_enclose(sim, with_forces, 0.0, b);
    gb_interval rate = gb_margin_rate(sim, at);
    if (sign > 0.0 ? !(rate.lo >= -BLUR * rate.hi) : !(rate.hi <= -BLUR * rate.lo)) {
        return 0;
    }
    gb_enclose(sim, with_forces, 0.5 * b, b);
    rate = gb_margin_rate(sim, at);
    return sign > 0.0 ? rate.lo >= 0.0 && rate.hi > 0.0 : rate.hi <= 0.0 && rate.lo < 0.0;
}

/* It may start on a corner: 0 beside how it moves over the piece [0, b], or where that is no more than rounding; what
 * is infinite there is far off. Seldom so long after an event; and where it has just flipped its side is known, unless
 * its rounding makes it flip. */
static int may_be_corner(const gb_sim *sim, gb_limit at, double b) {
    const struct gb_front *front = &sim->head->front;
    const gb_interval f = gb_margin(sim, at), rate = gb_margin_rate(sim, at);
    const double start = start_distance(sim, at), width = f.hi - f.lo,
                 motion = b * gb_max(fabs(rate.lo), fabs(rate.hi));
    if (sim->events.role[at.i] == GB_CONSTRAINED || !(rate.lo < 0.0 && start < HUGE_VAL) ||
        (!is_open(sim, at) && front->h > 1e-6 * (front->t0 - front->t_start))) {
        return 0;
    }
    const int early = front->t0 - sim->head->events.entered <= front->h;
    return start <= 1e-9 * width || (early && (start <= 1e-3 * width || width > 4.0 * motion));
}

/* It falls throughout over some piece [0, end], from end = b down. */
static int falls_ahead(gb_sim *sim, int with_forces, gb_limit at, double b, double tolerance) {
    double end = b;
    for (int look = 0; look < LOOKS_AHEAD && end > tolerance; look++, end *= 0.125) {
        if (goes(sim, with_forces, at, -1.0, end)) {
            return 1;
        }
        if (goes(sim, with_forces, at, 1.0, end)) {
            return 0;
        }
    }
    return 0;
}

int gb_leaves_corner(gb_sim *sim, int with_forces, gb_limit at, double b, double tolerance) {
    int leaves = 0;
    if (may_be_corner(sim, at, b)) {
        gb_enclose(sim, with_forces, 0.0, tolerance);
        const gb_interval start = gb_margin(sim, at);
        if (start.lo <= 0.0) {
            sim->panel.noise[at.i] = gb_max(sim->panel.noise[at.i], 2.0 * (start.hi - start.lo));
            leaves = is_open(sim, at) && falls_ahead(sim, with_forces, at, b, tolerance);
        }
        gb_enclose(sim, with_forces, 0.0, b);
    }
    return leaves;
}

int gb_never_inside(gb_sim *sim, gb_limit at, double root, int *never) {
    const double noise = sim->panel.noise[at.i];
    int code = GB_DONE;
    *never = noise > 0.0 && is_open(sim, at) && start_distance(sim, at) <= noise;
    for (int look = 0; look < LOOKS_BACK && *never && code == GB_DONE; look++) {
        root *= 0.5;
        code = gb_event_functions_at(sim, root, sim->events.s);
        *never = gb_limit_distance(sim, at.i, at.side, sim->events.s[at.i]) <= noise;
    }
    return code;
}
