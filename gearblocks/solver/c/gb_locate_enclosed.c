#include "gb_locate_enclosed.h"
#include "gb_dense_output.h"
#include "gb_enclosed_limit.h"
#include "gb_event_values.h"
#include "gb_force_enclosure.h"
#include "gb_force_noise.h"
#include "gb_limit_noise.h"
#include "gb_modes.h"
#include "gb_panel.h"
#include "gb_vector.h"

/* Open pieces of one step before noise is measured, and before the step is taken to be too long. */
enum { MANY_PIECES = 64, MOST_PIECES = 20000 };

enum { OPEN, FREE, ROOT };

static const double shortest_panel = 1.0 / 64.0;

/* The search along one step, over the piece [a, b]: nothing has been found before `until`. */
typedef struct search {
    double a, b, until, tolerance;
    int have_left, have_right; /* event functions at a and at b are known */
    int by_ends, open, untold; /* ends decide; how many pieces were open so far, the last for which one was */
    int with_forces;           /* constraint forces are enclosed too */
    int forces_inside;         /* they need not be, in this panel */
} search;

/* f has left its mode: a touch has not. Where the ends of a piece that can be no shorter decide, nor has what rounding
 * of the states does to it, in the rest of the step to twice as far: what drifts on is seldom met again. */
static int is_beyond(gb_sim *sim, const search *s, gb_limit at, double f) {
    const double enough = -(gb_starts_on_limit(sim, at) ? gb_margin_rounding(sim, at) : 0.0) - sim->panel.noise[at.i];
    if (s->by_ends && gb_min(f, gb_margin(sim, at).lo) < enough &&
        gb_is_noise(sim, at.i, f, sim->lanes.time_terms + sim->method->stages, sim->z, sim->y0)) {
        sim->panel.noise[at.i] = gb_max(sim->panel.noise[at.i], -2.0 * f);
        return 0;
    }
    return f < enough;
}

/* Its values alone tell that it is free. */
static int is_clear(const gb_sim *sim, gb_limit at) {
    return at.side == 0.0 || gb_margin(sim, at).lo >= -gb_margin_rounding(sim, at);
}

/* Rates over a piece so long tell nothing: its ends are not worth a look. */
static int is_hopeless(const gb_sim *sim, const search *s, gb_limit at) {
    const gb_interval f = gb_margin(sim, at), rate = gb_margin_rate(sim, at);
    return !(gb_min(-rate.lo, rate.hi) * (s->b - s->a) <= 2.0 * (f.hi - f.lo));
}

/* What the piece is by its ends and rates. */
static int verdict(gb_sim *sim, const search *s, gb_limit at) {
    const double fa = gb_limit_distance(sim, at.i, at.side, sim->panel.left[at.i]);
    const double fb = gb_limit_distance(sim, at.i, at.side, sim->panel.right[at.i]);
    const double enough = -gb_margin_rounding(sim, at) - sim->panel.noise[at.i];
    const gb_interval rate = gb_margin_rate(sim, at);
    if (is_beyond(sim, s, at, fb)) {
        return rate.hi <= 0.0 || s->by_ends ? ROOT : OPEN;
    }
    if (rate.hi <= 0.0 || rate.lo >= 0.0 || s->by_ends || gb_margin(sim, at).lo >= enough) {
        return FREE;
    }
    /* where the steepest fall from a meets the steepest rise to b */
    const double lowest = (fa * rate.hi - fb * rate.lo + rate.lo * rate.hi * (s->b - s->a)) / (rate.hi - rate.lo);
    return lowest >= enough ? FREE : OPEN;
}

/* The root of f in [from, to], which falls from fa >= 0 to fb < 0 with the given rates: secants, kept in the bracket
 * that each value gives with the rates (interval Newton). Behind the limit of another one the rates need not hold (a
 * capacity below zero is none): brackets that part tell, and then signs alone count. */
static int falling_root(gb_sim *sim, gb_limit at, double from, double to, double fa, double fb, double tolerance,
                        double *root) {
    const gb_interval rate = gb_margin_rate(sim, at);
    double a = from, b = to, x0 = from, f0 = fa, x1 = to, f1 = fb;
    int code = GB_DONE;
    for (int count = 0; count < 100 && b - a > tolerance && code == GB_DONE; count++) {
        double x = x1 - f1 * ((x1 - x0) / (f1 - f0));
        if (count % 4 == 3 || !(x > a && x < b)) {
            x = 0.5 * (a + b);
        }
        code = gb_event_functions_at(sim, x, sim->events.s);
        x0 = x1;
        f0 = f1;
        x1 = x;
        f1 = gb_limit_distance(sim, at.i, at.side, sim->events.s[at.i]);
        const double soon = x - f1 / rate.lo, late = x - f1 / rate.hi; /* by the steepest and by the flattest fall */
        a = gb_max(a, f1 < 0.0 ? (rate.hi < 0.0 ? late : a) : gb_max(x, soon));
        b = gb_min(b, f1 < 0.0 ? gb_min(x, soon) : (rate.hi < 0.0 ? late : b));
    }
    *root = 0.5 * (a + b);
    const int parted = code == GB_DONE && a - b > tolerance;
    return parted ? gb_true_root(sim, at.i, at.side, from, to, fa, fb, tolerance, root) : code;
}

/* It leaves its mode at the root. */
static void leave(gb_sim *sim, search *s, gb_limit at, double root) {
    if (root < sim->events.located[at.i]) {
        sim->events.located[at.i] = root;
        sim->events.side[at.i] = at.side;
    }
    s->until = gb_min(s->until, root);
}

/* The only root in the piece, if it is no later than what is found already. */
static int take_root(gb_sim *sim, search *s, gb_limit at) {
    const double fa = gb_max(gb_limit_distance(sim, at.i, at.side, sim->panel.left[at.i]), 0.0);
    double end = s->b, fb = gb_limit_distance(sim, at.i, at.side, sim->panel.right[at.i]), root = 0.0;
    int code = GB_DONE;
    if (s->until + s->tolerance < end) {
        end = s->until + s->tolerance;
        code = gb_event_functions_at(sim, end, sim->events.s);
        fb = gb_limit_distance(sim, at.i, at.side, sim->events.s[at.i]);
    }
    if (code != GB_DONE || !is_beyond(sim, s, at, fb)) {
        return code;
    }
    if (s->a > 0.0 || !gb_starts_on_limit(sim, at)) {
        code = falling_root(sim, at, s->a, end, fa, fb, s->tolerance, &root);
    }
    leave(sim, s, at, root);
    return code;
}

/* The roots in the piece up to the first: the one that the chords put first, then those that are as early. */
static int take_roots(gb_sim *sim, search *s) {
    const int n = gb_limits(sim->model);
    double soonest = HUGE_VAL;
    int first = 0, code = GB_DONE;
    for (int k = 0; k < n; k++) {
        const gb_limit at = gb_limit_at(sim, k);
        if (!is_clear(sim, at) && verdict(sim, s, at) == ROOT) {
            const double fa = gb_limit_distance(sim, at.i, at.side, sim->panel.left[at.i]);
            const double fb = gb_limit_distance(sim, at.i, at.side, sim->panel.right[at.i]);
            first = fa / (fa - fb) < soonest ? k : first;
            soonest = gb_min(soonest, fa / (fa - fb));
        }
    }
    code = take_root(sim, s, gb_limit_at(sim, first));
    for (int k = 0; k < n && code == GB_DONE; k++) {
        const gb_limit at = gb_limit_at(sim, k);
        if (k != first && !is_clear(sim, at) && verdict(sim, s, at) == ROOT) {
            code = take_root(sim, s, at);
        }
    }
    return code;
}

/* Event functions at the ends of the piece. */
static int look_at_ends(gb_sim *sim, search *s) {
    int code = s->have_left ? GB_DONE : gb_event_functions_at(sim, s->a, sim->panel.left);
    if (code == GB_DONE && !s->have_right) {
        code = gb_event_functions_at(sim, s->b, sim->panel.right);
    }
    s->have_left = s->have_right = 1;
    return code;
}

/* What the piece is by all that is enclosed: open where it is for one of them, then free where it is for all. */
static int judge_piece(gb_sim *sim, search *s, int *found) {
    const int n = gb_limits(sim->model);
    int clear = 1;
    *found = FREE;
    for (int k = 0; k < n; k++) {
        const gb_limit at = gb_limit_at(sim, k);
        if (!is_clear(sim, at)) {
            clear = 0;
            if (s->a == 0.0 && gb_leaves_corner(sim, s->with_forces && !s->forces_inside, at, s->b, s->tolerance)) {
                leave(sim, s, at, 0.0);
                *found = ROOT;
                return GB_DONE;
            }
            if (!s->by_ends && is_hopeless(sim, s, at)) {
                s->untold = at.i;
                *found = OPEN;
                return GB_DONE;
            }
        }
    }
    int code = clear ? GB_DONE : look_at_ends(sim, s);
    for (int k = 0; !clear && k < n && *found != OPEN; k++) {
        const gb_limit at = gb_limit_at(sim, k);
        const int one = is_clear(sim, at) ? FREE : verdict(sim, s, at);
        *found = one == FREE ? *found : one;
        s->untold = one == OPEN ? at.i : s->untold;
    }
    return code == GB_DONE && *found == ROOT ? take_roots(sim, s) : code;
}

/* Event function i stands on its limit wherever it is looked at, but for what the enclosure cannot tell (of a
 * constraint force, of which nothing is asked as long as a clipped contact lets go: but for its noise): at the start,
 * at both ends of the piece and at the end of the step, where it is `end`. A crossing is off it at one of them. */
static int stands(gb_sim *sim, int i, double end) {
    const gb_enclosure *g = &sim->panel.enclosure[i];
    const double *time_terms = sim->lanes.time_terms + sim->method->stages;
    double told = g->hi - g->lo, force = 0.0;
    if (sim->events.role[i] != GB_ORDINARY) {
        told = gb_min(told, gb_force_noise(sim, i, time_terms, sim->z, &force));
    }
    const double start = sim->events.s0[i], lo = sim->events.lo[i], hi = sim->events.hi[i];
    const double limit = start - lo < hi - start ? lo : hi, far = gb_max(fabs(start - limit), fabs(end - limit));
    return far <= told && fabs(sim->panel.left[i] - limit) <= told && fabs(sim->panel.right[i] - limit) <= told;
}

/* How finely event functions are told at all, after many open pieces: their width over hardly any time. One that has no
 * bounds even there (its numbers overflow) is left to samples, and so is one that something holds on its limit: that
 * the parts of it cancel is more than an enclosure knows. */
static void measure_noise(gb_sim *sim, const search *s) {
    const double *time_terms = sim->lanes.time_terms + sim->method->stages;
    gb_enclose(sim, s->with_forces && !s->forces_inside, s->a, gb_min(s->a + s->tolerance, sim->panel.to));
    sim->model->event_functions(sim->par, sim->mode, time_terms, sim->z, sim->events.s);
    for (int i = sim->model->n_affine; i < sim->model->n_event_functions; i++) {
        const gb_enclosure *g = &sim->panel.enclosure[i];
        const int bounded = g->up - g->down < HUGE_VAL,
                  held = s->have_left && s->have_right && stands(sim, i, sim->events.s[i]);
        sim->panel.watched[i] = sim->panel.watched[i] && g->hi - g->lo < HUGE_VAL && !held;
        sim->panel.noise[i] = sim->panel.watched[i] && bounded ? 2.0 * (g->hi - g->lo) : 0.0;
    }
}

/* Looks at a panel as a whole, as far as anything could be found in it: constraint forces that are inside their bounds
 * throughout are not enclosed over its pieces, and where all is clear by its values alone there are no pieces. */
static void look_at_panel(gb_sim *sim, search *s) {
    const double end = sim->panel.to;
    gb_enclose(sim, 0, s->a, end);
    s->forces_inside = s->with_forces && gb_forces_inside(sim);
    int clear = s->forces_inside == s->with_forces;
    for (int k = 0; k < gb_limits(sim->model) && clear; k++) {
        clear = is_clear(sim, gb_limit_at(sim, k));
    }
    if (clear) {
        s->a = end;
        s->have_left = 0;
    }
}

/* The panel that begins at `from`, as long as its polynomials hold, and the look at it. */
static int next_panel(gb_sim *sim, search *s, double from, double span) {
    int good = 0, halved = 0, code = GB_DONE;
    for (double width = gb_min(span, 1.0 - from); !good && code == GB_DONE; width *= 0.5) {
        code = gb_panel_fill(sim, from, width >= 1.0 - from ? 1.0 : from + width, halved, &good);
        good = good || width <= shortest_panel;
        halved = 1;
    }
    if (code == GB_DONE) {
        look_at_panel(sim, s);
    }
    return code;
}

/* Goes on behind a free piece. */
static void move_on(gb_sim *sim, search *s) {
    double *right = sim->panel.right;
    s->a = s->b;
    s->have_left = s->have_right;
    s->have_right = 0;
    if (s->have_left) {
        sim->panel.right = sim->panel.left;
        sim->panel.left = right;
    }
}

/* Watches the constraint forces, or leaves them to samples. */
static void watch_forces(gb_sim *sim, int watched) {
    for (int i = 0; i < sim->model->n_constraints; i++) {
        sim->panel.watched[sim->model->constraints[i].active] = watched;
    }
}

/* Which event functions are enclosed in this step, constraint forces where they agree with those at its start; the
 * first panel. Without a limit to watch the search is over. */
static int begin(gb_sim *sim, search *s) {
    const gb_model *model = sim->model;
    int code = GB_DONE, any = 0;
    for (int i = 0; i < model->n_affine; i++) {
        s->until = gb_min(s->until, sim->events.located[i]);
    }
    for (int i = model->n_affine; i < model->n_event_functions; i++) {
        sim->panel.noise[i] = 0.0;
        sim->panel.watched[i] = model->is_enclosed[i - model->n_affine];
    }
    for (int k = 0; k < model->n_arguments_read; k++) {
        sim->panel.rounding[k] = 0.0;
    }
    sim->panel.far = model->n_massless > 0 ? HUGE_VAL : gb_beyond_noise(sim, sim->z, sim->y0);
    s->with_forces = gb_forces_prepare(sim);
    watch_forces(sim, s->with_forces);
    for (int k = 0; k < gb_limits(model); k++) {
        any = any || gb_limit_at(sim, k).side != 0.0;
    }
    s->a = any ? 0.0 : 1.0;
    if (any) {
        code = gb_dense_complete(sim);
        code = code == GB_DONE ? next_panel(sim, s, 0.0, 1.0) : code;
    }
    if (code == GB_DONE && any && s->with_forces && !s->forces_inside) {
        gb_enclose(sim, 1, 0.0, s->tolerance);
        s->with_forces = gb_forces_agree(sim);
        watch_forces(sim, s->with_forces);
    }
    for (int i = model->n_affine; i < model->n_event_functions; i++) {
        sim->events.located[i] = 2.0;
    }
    return code;
}

/* Roots where a corner at the start is told from it at last: it has been left there. */
static int look_back(gb_sim *sim, const search *s) {
    int code = GB_DONE, never = 0;
    for (int k = 0; k < gb_limits(sim->model) && code == GB_DONE; k++) {
        const gb_limit at = gb_limit_at(sim, k);
        const double root = at.side != 0.0 && sim->events.side[at.i] == at.side ? sim->events.located[at.i] : 0.0;
        if (root > 0.0 && root <= s->until + s->tolerance) {
            code = gb_never_inside(sim, at, root, &never);
            sim->events.located[at.i] = never ? 0.0 : root;
        }
    }
    return code;
}

int gb_locate_enclosed(gb_sim *sim) {
    gb_head *head = sim->head;
    const double tolerance = gb_rounding(head->front.t0, head->front.h) / head->front.h;
    search s = {.until = 2.0, .tolerance = tolerance};
    double width = head->events.piece > 0.0 ? gb_min(1.0, 4.0 * head->events.piece / head->front.h) : 1.0;
    int code = begin(sim, &s), found = FREE;
    while (code == GB_DONE && found != ROOT && s.a < gb_min(s.until + s.tolerance, 1.0)) {
        if (s.a >= sim->panel.to) {
            code = next_panel(sim, &s, s.a, 2.0 * (sim->panel.to - sim->panel.from));
            continue;
        }
        s.b = s.a + 1.01 * width < sim->panel.to ? s.a + width : sim->panel.to;
        s.have_right = 0;
        s.by_ends = s.b - s.a <= s.tolerance || s.open > MOST_PIECES;
        gb_enclose(sim, s.with_forces && !s.forces_inside, s.a, s.b);
        code = judge_piece(sim, &s, &found);
        width = found == OPEN ? 0.5 * (s.b - s.a) : 2.0 * (s.b - s.a);
        if (found == FREE) {
            move_on(sim, &s);
        } else if (found == ROOT) {
            head->events.piece = (s.b - s.a) * head->front.h;
        } else if (s.open++ == MANY_PIECES) {
            measure_noise(sim, &s);
        }
    }
    sim->events.undersampled = s.open > MOST_PIECES ? s.untold + 1 : 0;
    return code == GB_DONE && found == ROOT ? look_back(sim, &s) : code;
}
