/* Inputs and what laws hoist out because it depends on time alone, at instants.
 * Knows nothing of states. */
#ifndef GB_TIME_TERMS_H
#define GB_TIME_TERMS_H

#include "gb_internal.h"

/* Inputs and time terms at `lanes` instants; the last instant fills the lanes that are left. */
int gb_time_terms(gb_sim *sim, int lanes, gb_lanes *at);

/* The same at one instant, into `instant`. */
int gb_time_terms_at(gb_sim *sim, double t);

#endif
