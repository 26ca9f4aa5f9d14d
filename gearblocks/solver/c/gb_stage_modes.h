/* Modes at a stage of a run without location: m = m(g(t, y, m)) at the state of each stage, as an `if` in every
 * right-hand side has it, instead of modes frozen over the step. Assumed: time terms of all lanes for the modes in
 * unlocated.mode; they are made anew where a mode changes, since they may read it. Switched constraints keep the modes
 * of the step's start: their forces are decided together, at its end. Knows nothing of events, methods and steps. */
#ifndef GB_STAGE_MODES_H
#define GB_STAGE_MODES_H

#include "gb_internal.h"

/* The modes of the front are those of the next stage, too; time terms are there for `lanes`. */
void gb_stage_modes_begin(gb_sim *sim, int lanes);

/* Modes that fit y at lane `lane` of `at`, of which `lanes` are in use, into unlocated.mode. Returns the switch that
 * finds none, or -1. */
int gb_stage_modes(gb_sim *sim, const gb_lanes *at, int lanes, int lane, const double *y);

/* The rates (with `full` those of the quadratures too) at stage `lane` of a step on its own modes. */
void gb_stage_rates(gb_sim *sim, int lane, int full, const double *y, double *dy);

#endif
