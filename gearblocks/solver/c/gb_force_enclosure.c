#include "gb_force_enclosure.h"
#include "gb_constraint_rows.h"
#include "gb_enclosure.h"
#include "gb_vector.h"

/* What is known about the constraint forces in the present modes: they are no function of the torques; they are; and
 * nothing else has a limit, nor are they functions of anything but time and states. */
enum { UNKNOWN, NO_FUNCTION, FUNCTION, ALONE };

/* Steps for which a box is made: at first, and at most where boxes prove good. */
static const double AHEAD = 16.0, FAR_AHEAD = 256.0;

/* Fills in what they answer to torques. */
static int is_function(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int n = model->n_constraints, m = model->n_groups;
    const double *active = sim->mode + model->n_switches;
    double *unit = sim->panel.unit;
    if (!model->force_enclosures || !sim->panel.response || active[GB_ACTIVE_COUNT] == 0.0) {
        return 0;
    }
    for (int i = 0; i < n; i++) {
        if (active[gb_active_redundant(n) + i] != 0.0 && sim->mode[model->constraints[i].active] > 0.5) {
            return 0;
        }
    }
    for (int g = 0; g < m; g++) {
        memset(unit, 0, sizeof(double) * (size_t)m);
        unit[g] = 1.0;
        model->forces_of_torques(sim->par, sim->mode, unit, sim->panel.response + (size_t)g * (size_t)n);
    }
    return 1;
}

/* By the limits of the modes, not by those of this step: what is held, or was noise, is watched again in the next. */
static int is_alone(const gb_sim *sim) {
    const gb_model *model = sim->model;
    double *lo = sim->events.moved, *hi = sim->events.until;
    model->mode_limits(sim->par, sim->mode, lo, hi);
    for (int i = 0; i < model->n_constraints; i++) {
        const int at = model->constraints[i].active;
        lo[at] = -HUGE_VAL;
        hi[at] = HUGE_VAL;
    }
    for (int i = 0; i < model->n_event_functions; i++) {
        if (lo[i] > -HUGE_VAL || hi[i] < HUGE_VAL) {
            return 0;
        }
    }
    for (int k = 0; k < model->n_arguments_read; k++) {
        if (model->arguments_read[k] >= 1 + model->n_inputs + model->n) {
            return 0;
        }
    }
    return 1;
}

static int what_is_known(gb_sim *sim) {
    struct gb_panel *panel = &sim->panel;
    if (panel->known == UNKNOWN || panel->known_modes != sim->head->events.mode_hash) {
        panel->known = !is_function(sim) ? NO_FUNCTION : is_alone(sim) ? ALONE : FUNCTION;
        panel->known_modes = sim->head->events.mode_hash;
        panel->boxed = panel->has_kept = 0;
        panel->ahead = AHEAD;
    }
    return panel->known;
}

int gb_forces_prepare(gb_sim *sim) {
    sim->panel.boxed = 0;
    return what_is_known(sim) >= FUNCTION;
}

/* lambda of constraint i. */
static gb_enclosure constraint_force(const gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    gb_enclosure sum = gb_enclosed_number(0.0);
    for (int g = 0; g < model->n_groups; g++) {
        const double gain = sim->panel.response[(size_t)g * (size_t)model->n_constraints + (size_t)i];
        const gb_enclosure *torque = &sim->panel.torque[g];
        const int is_zero = torque->lo == 0.0 && torque->hi == 0.0 && torque->down == 0.0 && torque->up == 0.0;
        if (gain != 0.0 && !is_zero) {
            sum = gb_enclosed_add(sum, gb_enclosed_scale(*torque, gain));
        }
    }
    return sum;
}

/* The larger of both. */
static gb_enclosure larger(gb_enclosure a, gb_enclosure b) {
    if (a.lo >= b.hi || b.hi == -HUGE_VAL) {
        return a;
    }
    if (b.lo >= a.hi || a.hi == -HUGE_VAL) {
        return b;
    }
    const gb_enclosure x = {fmax(a.lo, b.lo), fmax(a.hi, b.hi), fmin(a.down, b.down), fmax(a.up, b.up)};
    return x;
}

/* The event functions of constraint forces where the arguments are x. */
static void enclose_over(gb_sim *sim, const gb_enclosure *x) {
    const gb_model *model = sim->model;
    const gb_enclosure never = {-HUGE_VAL, -HUGE_VAL, 0.0, 0.0};
    model->force_enclosures(sim->par, sim->mode, x, sim->panel.torque, sim->panel.bound);
    for (int i = 0; i < model->n_constraints; i++) {
        const int at = model->constraints[i].active;
        sim->panel.enclosure[at] = gb_enclosed_number(-1.0);
        if (sim->mode[at] > 0.5) {
            const gb_enclosure force = constraint_force(sim, i), lower = sim->panel.bound[2 * i];
            const gb_enclosure upper = sim->panel.bound[2 * i + 1];
            const gb_enclosure over =
                upper.lo < HUGE_VAL ? gb_enclosed_add(force, gb_enclosed_scale(upper, -1.0)) : never;
            const gb_enclosure under =
                lower.hi > -HUGE_VAL ? gb_enclosed_add(lower, gb_enclosed_scale(force, -1.0)) : never;
            const gb_enclosure excess = larger(over, under);
            sim->panel.enclosure[at] = excess.hi > -HUGE_VAL ? excess : gb_enclosed_number(-1.0);
        }
    }
}

void gb_forces_enclose(gb_sim *sim) {
    enclose_over(sim, sim->panel.x);
}

/* The event functions at the start of the step lie in what is enclosed. */
static int agree(const gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_constraints; i++) {
        const int at = model->constraints[i].active;
        const gb_enclosure *g = &sim->panel.enclosure[at];
        const double size = 1e-9 * (gb_max(fabs(g->lo), fabs(g->hi)) + fabs(sim->events.s0[at]));
        if (sim->mode[at] > 0.5 && !(sim->events.s0[at] >= g->lo - size && sim->events.s0[at] <= g->hi + size)) {
            return 0;
        }
    }
    return 1;
}

int gb_forces_agree(gb_sim *sim) {
    sim->head->events.forces_agreed = agree(sim);
    return sim->head->events.forces_agreed;
}

/* What is enclosed is inside the bounds. */
static int are_inside(const gb_sim *sim) {
    const gb_model *model = sim->model;
    int inside = 1;
    for (int i = 0; i < model->n_constraints && inside; i++) {
        inside = sim->panel.enclosure[model->constraints[i].active].hi < 0.0;
    }
    return inside;
}

/* The values of argument j lie in the box that is kept; a new one reaches beyond them. */
static int is_kept(const gb_sim *sim, int j) {
    return sim->panel.x[j].lo >= sim->panel.kept[j].lo && sim->panel.x[j].hi <= sim->panel.kept[j].hi;
}

static void keep(gb_sim *sim, int j, double reach) {
    const gb_enclosure *x = &sim->panel.x[j];
    const double more = reach > 0.0 ? reach * (x->hi - x->lo) : 0.0;
    const gb_enclosure box = {x->lo - more, x->hi + more, 0.0, 0.0};
    sim->panel.kept[j] = box;
}

/* A box around the arguments in which the forces are inside: as large as it may be, since steps that follow are told by
 * it as well. */
static int find_kept(gb_sim *sim) {
    const gb_model *model = sim->model;
    struct gb_panel *panel = &sim->panel;
    double reach = panel->kept_reach > 0.0 ? gb_min(2.0 * panel->kept_reach, AHEAD) : 1.0;
    int inside = 0;
    for (int attempt = 0; attempt < 2 && !inside; attempt++) {
        keep(sim, 0, reach);
        for (int k = 0; k < model->n_arguments_read; k++) {
            keep(sim, model->arguments_read[k], reach);
        }
        enclose_over(sim, panel->kept);
        inside = are_inside(sim);
        panel->kept_reach = reach;
        reach = 0.0;
    }
    return inside && agree(sim);
}

int gb_forces_inside(gb_sim *sim) {
    const gb_model *model = sim->model;
    struct gb_panel *panel = &sim->panel;
    int inside = panel->has_kept && is_kept(sim, 0);
    if (!sim->head->events.forces_agreed) {
        return 0;
    }
    for (int k = 0; k < model->n_arguments_read && inside; k++) {
        inside = is_kept(sim, model->arguments_read[k]);
    }
    panel->has_kept = inside || find_kept(sim);
    for (int i = 0; i < model->n_constraints && panel->has_kept; i++) {
        panel->enclosure[model->constraints[i].active] = gb_enclosed_number(-1.0);
    }
    return panel->has_kept;
}

/* State i over the step, coarsely: it moves from both ends by no more than the largest of the stages' rates would have
 * it, as many times as said. */
static gb_interval state_over_step(const gb_sim *sim, int i, double times) {
    double rate = 0.0;
    for (int l = 0; l <= sim->method->stages; l++) {
        rate = gb_max(rate, fabs(sim->k[(size_t)l * (size_t)sim->model->n_total + (size_t)i]));
    }
    const double reach = times * sim->head->front.h * rate;
    const gb_interval x = {gb_min(sim->y0[i], sim->z[i]) - reach, gb_max(sim->y0[i], sim->z[i]) + reach};
    return x;
}

/* A box around all that forces and bounds are functions of, over this step and some that follow. */
static void make_box(gb_sim *sim, double times) {
    const gb_model *model = sim->model;
    const struct gb_front *front = &sim->head->front;
    const gb_enclosure time = {front->t0, front->t0 + times * front->h, 0.0, 0.0};
    sim->panel.x[0] = time;
    for (int k = 0; k < model->n_arguments_read; k++) {
        const int j = model->arguments_read[k], i = j - 1 - model->n_inputs;
        const gb_interval still = {0.0, 0.0};
        if (i >= 0) {
            sim->panel.x[j] = gb_enclosed(state_over_step(sim, i, times), still);
        } else if (j > 0) {
            sim->panel.x[j] = gb_enclosed_number(sim->inputs.value[j - 1]);
        }
    }
}

static int is_in_box(const gb_sim *sim) {
    const gb_model *model = sim->model;
    const gb_enclosure *x = sim->panel.x;
    const struct gb_front *front = &sim->head->front;
    int inside = front->t0 >= x->lo && front->t0 + front->h <= x->hi;
    for (int k = 0; k < model->n_arguments_read && inside; k++) {
        const int j = model->arguments_read[k], i = j - 1 - model->n_inputs;
        if (i >= 0) {
            const gb_interval state = state_over_step(sim, i, 1.0);
            inside = state.lo >= x[j].lo && state.hi <= x[j].hi;
        } else if (j > 0) {
            inside = sim->inputs.value[j - 1] == x[j].lo;
        }
    }
    return inside;
}

int gb_forces_stay(gb_sim *sim) {
    if (!sim->head->events.forces_agreed || sim->inputs.n_moving > 0 || what_is_known(sim) != ALONE) {
        return 0;
    }
    struct gb_panel *panel = &sim->panel;
    int stay = panel->boxed && is_in_box(sim);
    for (double times = panel->ahead; !stay && times > 0.0; times = times > 1.0 ? 1.0 : 0.0) {
        make_box(sim, times);
        gb_forces_enclose(sim);
        stay = are_inside(sim);
        panel->boxed = stay;
        panel->ahead = stay && times > 1.0 ? gb_min(2.0 * times, FAR_AHEAD) : gb_max(0.25 * times, AHEAD);
    }
    return stay;
}
