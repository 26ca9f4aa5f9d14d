/* What the tolerance of a run admits for a combination of its states: sum_j |ds/dy_j| / (error weight of j).
 * Knows nothing of steps and impacts. */
#ifndef GB_TOLERANCE_H
#define GB_TOLERANCE_H

#include "gb_internal.h"

/* Of event function i at the front. */
double gb_tolerance_of(gb_sim *sim, int i);

/* The same at a state y whose event functions are events.s, as far as states matter that have faded below their own. */
double gb_tolerance_at(gb_sim *sim, int i, const double *time_terms, const double *y);

/* Of all event functions, by states alone that are small beside what counts as a size for them. */
void gb_tolerances_of_small(gb_sim *sim, double *sum);

/* Of the slip of constraint i. */
double gb_tolerance_of_slip(gb_sim *sim, int i);

#endif
