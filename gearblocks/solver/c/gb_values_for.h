/* Event functions at a state, for the sake of one of them. An affine one reads coordinates and numbers alone: the
 * forces of active constraints, which may take a split (gb_force_split.h), are spared, and nothing else changes.
 * Knows nothing of limits. */
#ifndef GB_VALUES_FOR_H
#define GB_VALUES_FOR_H

#include "gb_internal.h"

static inline void gb_values_for(gb_sim *sim, int i, const double *time_terms, const double *y, double *s) {
    const gb_model *model = sim->model;
    double ignored = 0.0, *active = model->n_constraints > 0 ? sim->mode + model->n_switches : &ignored;
    const double count = *active; /* of active constraints: where it is 0 no force is asked for */
    *active = i < model->n_affine ? 0.0 : count;
    model->event_functions(sim->par, sim->mode, time_terms, y, s);
    *active = count;
}

#endif
