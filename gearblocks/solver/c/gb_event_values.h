/* Event functions along the step just computed, by their true values: distances to a limit, its root and its dips.
 * False position with the Illinois rule (Dowell and Jarratt 1971), golden section (Kiefer 1953). Knows nothing of
 * samples. */
#ifndef GB_EVENT_VALUES_H
#define GB_EVENT_VALUES_H

#include "gb_internal.h"

/* All event functions at theta, into s. */
int gb_event_functions_at(gb_sim *sim, double theta, double *s);

/* Distance of event function i to its limit `side`; from its start value where it is armed there. */
double gb_limit_distance(const gb_sim *sim, int i, double side, double s);

/* The root in [a, b] with distance(a) >= 0 > distance(b): false position with the Illinois rule, then halving. */
int gb_true_root(gb_sim *sim, int i, double side, double a, double b, double fa, double fb, double tolerance,
                 double *root);

/* Looks for a negative distance between a and b around the low sample m; *x is where it was found, *f its value. */
int gb_true_dip(gb_sim *sim, int i, double side, double a, double m, double b, double fm, double *x, double *f);

#endif
