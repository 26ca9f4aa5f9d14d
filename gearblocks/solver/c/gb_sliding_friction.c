#include "gb_sliding_friction.h"
#include "gb_constraint_state.h"
#include "gb_modes.h"
#include "gb_rates.h"
#include "gb_vector.h"

/* The time terms above the limit of switch i alone, and its modes, into sliding.mode. */
static const double *terms_above(gb_sim *sim, int i) {
    memcpy(sim->sliding.mode, sim->mode, sizeof(double) * sim->unlocated.n_carried);
    sim->sliding.mode[i] += 1.0;
    return gb_terms_above(sim, &sim->instant, 0);
}

void gb_rub_on_both_sides(gb_sim *sim, int i, double mode) {
    const gb_model *model = sim->model;
    const int n = model->n_event_functions, slides = mode != floor(mode);
    double *below = sim->sliding.functions, *above = below + n;
    if (model->n_constraints == 0) {
        return;
    }
    model->event_functions(sim->par, sim->mode, sim->instant.time_terms, sim->y, below);
    const double *terms = terms_above(sim, i);
    model->event_functions(sim->par, sim->sliding.mode, terms, sim->y, above);
    for (int c = 0; c < model->n_constraints; c++) {
        const gb_constraint *of = &model->constraints[c];
        const int may = of->kind == GB_FRICTION && of->free >= 0 && of->free < n && !gb_is_active(sim, c);
        if (may && below[of->slip] != 0.0 && (below[of->free] == 0.0) != (above[of->free] == 0.0)) {
            const int rubs = slides || (mode > sim->mode[i] ? above : below)[of->free] < 0.0;
            gb_set_mode(sim, of->free, rubs ? 0.0 : 1.0, 0);
            gb_set_mode(sim, of->slip, !rubs ? 0.0 : below[of->slip] > 0.0 ? 1.0 : -1.0, 0);
        }
    }
}

int gb_stronger_side(gb_sim *sim, int i, int c) {
    const gb_model *model = sim->model;
    const gb_constraint *of = &model->constraints[c];
    double *bounds = sim->constraints.bounds;
    if (of->kind != GB_FRICTION || gb_is_active(sim, c) || sim->events.pending[of->slip] == 0.0) {
        return -1;
    }
    model->force_bounds(sim->par, sim->mode, sim->instant.time_terms, sim->y, bounds);
    const double below = bounds[5 * c + 4];
    const double *terms = terms_above(sim, i);
    model->force_bounds(sim->par, sim->sliding.mode, terms, sim->y, bounds);
    const double above = bounds[5 * c + 4];
    return above == below ? -1 : above > below;
}
