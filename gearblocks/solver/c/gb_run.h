/* Runs: to communication points, through samples, or recording every step; recorded rows evaluated. The calls are
 * those of gb_core.h: gb_advance, gb_time, gb_state, gb_outputs, gb_energies, gb_rhs, gb_run, gb_evaluate.
 * Knows nothing of methods and events beyond that some are pending. */
#ifndef GB_RUN_H
#define GB_RUN_H

#include "gb_core.h"

/* The front moves on towards the target: what is pending there is applied, or else a step is taken. */
int gb_move(gb_sim *sim, double target);

#endif
