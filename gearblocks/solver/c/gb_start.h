/* The start of a run and its restart after parameters or inputs were written: values, start state, modes that agree
 * with each other.
 * Knows nothing of steps. */
#ifndef GB_START_H
#define GB_START_H

#include "gb_internal.h"

/* Written parameters or inputs take effect: the run restarts from the communication point. */
int gb_apply_changes(gb_sim *sim);

#endif
