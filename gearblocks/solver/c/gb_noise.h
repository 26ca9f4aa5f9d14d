/* Noise: how far rounding of the states and of time moves each rate. It is measured as the response to a change in the
 * last bits, and counts as error of a step beside the tolerance.
 * Knows nothing of tolerances and of steps that are refused. */
#ifndef GB_NOISE_H
#define GB_NOISE_H

#include "gb_internal.h"

/* What rounding leaves of the forces of locks in the state y at the end of a step: where nothing else moves a speed,
 * its whole rate. These accelerations lie in the row `left`; 1: some are beyond the noise that is known. */
int gb_noise_of_locks(gb_sim *sim, const double *time_terms, const double *y, double *left);

/* How far rounding moves each rate: the response to a change of the states in their last bits, of signs that differ
 * from one measurement to the next. What starts from rest has the bits of what a first step of h reaches: a slip that
 * is held beside it is as noisy as that. left: accelerations that are rounding (0 where none are known), which reach
 * further rates by their speeds. valid: noise that is known stays the least where that time of it makes all that a
 * state has been. */
void gb_measure_noise(gb_sim *sim, double h, const gb_lanes *at, double *left, double valid);

/* State i has a scale of its own: it has moved by more than what counts as one for its kind. */
static inline int gb_has_scale(const gb_sim *sim, int i) {
    const struct gb_pace *control = &sim->head->control;
    const int speed = i >= sim->model->n - sim->model->n_speeds;
    return sim->head->counts.steps > 0 &&
           sim->control.largest[i] > (speed ? control->least_speed : control->least_coordinate);
}

#endif
