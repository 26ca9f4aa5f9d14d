#include "gb_mode_search.h"
#include "gb_evaluate.h"
#include "gb_limit_noise.h"
#include "gb_modes.h"
#include "gb_time_terms.h"

/* Most sets of modes that are looked at, most that are other ones in a set, and most to choose from. */
enum { TRIES = 20000, DEEPEST = 8, OPTIONS = 64 };

/* Switch i in another mode than the present one, beyond its limit `side`. */
typedef struct option {
    int i;
    double present, mode, side;
} option;

/* -1 or 1: event function i is beyond its lower or upper limit by more than rounding. */
static int beyond(const gb_sim *sim, int i) {
    const double s = sim->events.s[i], lo = sim->events.lo[i], hi = sim->events.hi[i];
    const double unit = 64.0 * DBL_EPSILON;
    if (sim->events.armed[i] != -1.0 && lo > -HUGE_VAL && s < lo - unit * (fabs(s) + fabs(lo))) {
        return -1;
    }
    return sim->events.armed[i] != 1.0 && hi < HUGE_VAL && s > hi + unit * (fabs(s) + fabs(hi));
}

int gb_is_beyond(gb_sim *sim, int i) {
    const int side = beyond(sim, i);
    const double distance = side == 0 ? 0.0 : sim->events.s[i] - (side < 0 ? sim->events.lo[i] : sim->events.hi[i]);
    return side != 0 && !gb_is_noise(sim, i, distance, sim->instant.time_terms, sim->y, sim->y);
}

int gb_balance_is_singular(const gb_sim *sim) {
    int finite = 1;
    for (int i = 0; i < sim->model->n_event_functions && sim->model->balance_massless; i++) {
        finite = finite && sim->events.s[i] - sim->events.s[i] == 0.0;
    }
    return !finite;
}

/* The other modes of switches of massless speeds, with `all` of those that have just flipped, too; returns how many. */
static int options_of(gb_sim *sim, int all, option *options) {
    int n = 0;
    gb_mode_limits(sim);
    for (int i = sim->model->n_affine; i < sim->model->n_event_functions; i++) {
        const int free = sim->events.role[i] != GB_CONSTRAINED && (all || sim->events.armed[i] == 0.0);
        for (int side = -1; side <= 1 && free; side += 2) {
            const double limit = side < 0 ? sim->events.lo[i] : sim->events.hi[i];
            const double mode = fabs(limit) < HUGE_VAL ? gb_far_side(sim, i, side) : sim->mode[i];
            if (mode != sim->mode[i] && n < OPTIONS) {
                options[n++] = (option){i, sim->mode[i], mode, side};
            }
        }
    }
    return n;
}

/* Those of `chosen` agree as soon as time can be told from now on, with these rates: where one has just crossed its
 * limit, it is beyond by then. */
static int agree_ahead(gb_sim *sim, const option *options, const int *chosen, int count, const double *rate) {
    const gb_model *model = sim->model;
    const double t = sim->head->front.t1, ahead = 4.0 * gb_rounding(t, sim->head->control.h_largest);
    double y[model->n_total];
    memcpy(y, sim->y, sizeof y);
    for (int i = 0; i < model->n; i++) {
        y[i] += ahead * rate[i];
    }
    int fits = gb_time_terms_at(sim, t + ahead) == GB_DONE;
    model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, sim->events.s);
    fits = fits && !gb_balance_is_singular(sim);
    for (int j = 0; j < count && fits; j++) {
        const int i = options[chosen[j]].i;
        sim->events.armed[i] = 0.0;
        fits = !gb_is_beyond(sim, i);
        sim->events.armed[i] = -options[chosen[j]].side;
    }
    return fits;
}

/* All event functions agree with the present modes, those of `chosen` as soon as time can be told: by the rates now, or
 * by those that led here. */
static int all_agree(gb_sim *sim, const option *options, const int *chosen, int count) {
    const gb_model *model = sim->model;
    double rate[model->n_total];
    gb_mode_limits(sim);
    int fits = gb_event_functions_now(sim) == GB_DONE && !gb_balance_is_singular(sim);
    for (int i = 0; i < model->n_event_functions && fits; i++) {
        fits = sim->events.role[i] == GB_CONSTRAINED || !gb_is_beyond(sim, i);
    }
    if (fits) {
        model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, rate);
    }
    return fits &&
           (agree_ahead(sim, options, chosen, count, rate) || agree_ahead(sim, options, chosen, count, sim->k1));
}

/* The same with the modes of `chosen`, which are not taken. */
static int agree(gb_sim *sim, const option *options, const int *chosen, int count) {
    double armed[DEEPEST];
    for (int j = 0; j < count; j++) {
        const option *of = &options[chosen[j]];
        gb_set_mode(sim, of->i, of->mode, 0);
        armed[j] = sim->events.armed[of->i];
        sim->events.armed[of->i] = -of->side;
    }
    const int fits = all_agree(sim, options, chosen, count);
    for (int j = count - 1; j >= 0; j--) {
        const option *of = &options[chosen[j]];
        gb_set_mode(sim, of->i, of->present, 0);
        sim->events.armed[of->i] = armed[j];
    }
    return fits;
}

/* The next `count` of n numbers that grow; 0: these were the last. */
static int next_choice(int *chosen, int count, int n) {
    int j = count - 1;
    while (j >= 0 && chosen[j] == n - count + j) {
        j--;
    }
    for (int k = j; k >= 0 && k < count; k++) {
        chosen[k] = k == j ? chosen[k] + 1 : chosen[k - 1] + 1;
    }
    return j >= 0;
}

/* No switch is chosen twice. */
static int is_a_set(const option *options, const int *chosen, int count) {
    for (int j = 1; j < count; j++) {
        if (options[chosen[j]].i == options[chosen[j - 1]].i) {
            return 0;
        }
    }
    return 1;
}

static void take(gb_sim *sim, const option *options, const int *chosen, int count, int log) {
    for (int j = 0; j < count; j++) {
        const int i = options[chosen[j]].i;
        gb_set_mode(sim, i, options[chosen[j]].mode, log && sim->events.role[i] == GB_ORDINARY);
        sim->events.armed[i] = -options[chosen[j]].side;
        sim->head->events.armed = 1;
    }
    gb_mode_limits(sim);
}

/* As gb_search_modes, among these options. */
static int search(gb_sim *sim, const option *options, int n, int log) {
    int chosen[DEEPEST], tries = 0;
    for (int count = 1; count <= n && count <= DEEPEST; count++) {
        for (int j = 0; j < count; j++) {
            chosen[j] = j;
        }
        do {
            if (is_a_set(options, chosen, count) && agree(sim, options, chosen, count)) {
                take(sim, options, chosen, count, log);
                return 1;
            }
        } while (++tries < TRIES && next_choice(chosen, count, n));
        if (tries >= TRIES) {
            break;
        }
    }
    return 0;
}

int gb_search_modes(gb_sim *sim, int log) {
    option options[OPTIONS];
    if (!sim->model->balance_massless) {
        return 0;
    }
    const int some = options_of(sim, 0, options);
    int found = search(sim, options, some, log);
    if (!found) {
        gb_mode_limits(sim);
        const int all = options_of(sim, 1, options);
        found = all > some && search(sim, options, all, log);
    }
    gb_mode_limits(sim);
    return gb_event_functions_now(sim) == GB_DONE && found;
}
