/* The motion a little ahead in the present modes, by the classical method of order 4 (Kutta 1901): what no event
 * function at the present state tells, since it leaves its limit like a high power of time, is told by the state to
 * come. A load is carried on by as many links as there are stages; a step of Euler carries it through one.
 * Knows nothing of tolerances, of modes that end meanwhile and of what is decided by the state. */
#ifndef GB_FOLLOW_H
#define GB_FOLLOW_H

#include "gb_internal.h"

/* A row of the size of a state where stages are kept. */
static inline double *gb_scratch_row(const gb_sim *sim, int number) {
    return sim->k + (size_t)number * (size_t)sim->model->n_total;
}

/* The state after `time` in so many steps, from the front; `instant` holds its time terms afterwards. */
int gb_follow(gb_sim *sim, double time, int steps, double *state);

/* The same, and the event functions there, into s. */
int gb_follow_functions(gb_sim *sim, double time, int steps, double *state, double *s);

/* The state alone, or a quarter as far as often as it takes: what the classical method makes of a motion much faster
 * than its steps is no number in the end. */
int gb_follow_finite(gb_sim *sim, double time, int steps, double *state);

#endif
