#include "gb_turned_gears.h"
#include "gb_rates.h"
#include "gb_vector.h"

enum { MOST = 8 }; /* gears of which every combination is tried */

int gb_sign_of_gear(const gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    for (int c = 0; c < model->n_constraints && c < 64; c++) {
        const gb_constraint *tie = &model->constraints[c];
        if (tie->kind == GB_TIE && tie->slip == i && sim->mode[model->constraints[tie->partner].slip] != 0.0) {
            return c;
        }
    }
    return -1;
}

/* Of which the value of one may be the rounding. */
static double size_of_forces(const gb_sim *sim, const double *value) {
    double size = 0.0;
    for (int c = 0; c < sim->model->n_constraints; c++) {
        const int sign = sim->model->constraints[c].slip;
        size += gb_sign_of_gear(sim, sign) == c ? fabs(value[sign]) : 0.0;
    }
    return size;
}

/* The signs of these modes are those of the forces there. */
static int agree(gb_sim *sim, const double *mode, const double *time_terms) {
    const gb_model *model = sim->model;
    double *value = sim->sliding.functions;
    model->event_functions(sim->par, mode, time_terms, sim->y, value);
    for (int c = 0; c < model->n_constraints && c < 64; c++) {
        const int sign = model->constraints[c].slip;
        if (gb_sign_of_gear(sim, sign) == c && !gb_sign_agrees(mode[sign], value[sign], size_of_forces(sim, value))) {
            return 0;
        }
    }
    return 1;
}

int gb_turn_gears(gb_sim *sim) {
    const gb_model *model = sim->model;
    int gear[MOST], count = 0;
    sim->head->events.turned = 0;
    for (int c = 0; c < model->n_constraints && c < 64 && sim->head->events.n_sliding == 1; c++) {
        if (gb_sign_of_gear(sim, model->constraints[c].slip) == c) {
            if (count == MOST) {
                return 0;
            }
            gear[count++] = c;
        }
    }
    for (int which = 0; which < 1 << count && count > 0; which++) {
        sim->head->events.turned = 0;
        for (int k = 0; k < count; k++) {
            sim->head->events.turned |= (uint64_t)(which >> k & 1) << gear[k];
        }
        gb_set_above(sim, 1);
        if (agree(sim, sim->sliding.mode, gb_terms_above(sim, &sim->instant, 0))) {
            return 1;
        }
    }
    sim->head->events.turned = 0;
    return count == 0;
}
