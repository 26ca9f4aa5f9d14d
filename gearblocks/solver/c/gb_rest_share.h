/* What holds at rest on the limit of a condition: a friction, by a force within bounds, or a lossy gear, by one within
 * what it loses of the force that it passes on. Between the two modes of the condition both forces are means by its
 * share.
 * Knows nothing of how what rests has come there. */
#ifndef GB_REST_SHARE_H
#define GB_REST_SHARE_H

#include "gb_internal.h"

/* Of one mode: the constraint force that holds, that of its tie (of a lossy gear), and the first four of its bounds. */
typedef struct gb_held_force {
    double force, tie, bounds[4];
} gb_held_force;

/* Of constraint c at the time terms and the state y, in modes with their active set. */
gb_held_force gb_held_force_in(gb_sim *sim, const double *mode, const double *time_terms, const double *y, int c);

/* Least and largest force that holds beside the one of the tie. */
void gb_held_range(const gb_sim *sim, int c, const gb_held_force *in, double range[2]);

/* The share of the second mode by which the mean of the forces of constraint c is one that holds: a half, or the
 * nearest to that; beyond its ends where none is, or where nothing is
 * asked that differs between the modes. */
double gb_rest_share(const gb_sim *sim, int c, const gb_held_force in[2]);

#endif
