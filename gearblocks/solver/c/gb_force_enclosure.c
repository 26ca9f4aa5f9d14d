#include "gb_force_enclosure.h"
#include "gb_constraint_rows.h"
#include "gb_enclosure.h"
#include "gb_vector.h"

int gb_forces_prepare(gb_sim *sim) {
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

/* lambda of constraint i. */
static gb_enclosure constraint_force(const gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    gb_enclosure sum = gb_enclosed_number(0.0);
    for (int g = 0; g < model->n_groups; g++) {
        const double gain = sim->panel.response[(size_t)g * (size_t)model->n_constraints + (size_t)i];
        if (gain != 0.0) {
            sum = gb_enclosed_add(sum, gb_enclosed_scale(sim->panel.torque[g], gain));
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

void gb_forces_enclose(gb_sim *sim) {
    const gb_model *model = sim->model;
    const gb_enclosure never = {-HUGE_VAL, -HUGE_VAL, 0.0, 0.0};
    model->force_enclosures(sim->par, sim->mode, sim->panel.x, sim->panel.torque, sim->panel.bound);
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

int gb_forces_agree(const gb_sim *sim) {
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
