/* How large a load may be for forces within their bounds to hold it. Forces that the motion does not tell; of a load c
 * (slip accelerations), the largest factor r with  W x = r c,  lower <= x <= upper,  and the losses of gears at rest
 * within the range that the forces of their ties leave them (gb_loss.h). A linear program for each combination of sides
 * of the gears; ranges become narrower beyond r = 1 by what the slopes of the losses make of the load itself, so that r
 * has no jump where forces in proportion to each other come to no limit. Knows nothing of the motion. */
#ifndef GB_LOAD_LIMIT_H
#define GB_LOAD_LIMIT_H

#include "gb_force_bounds.h"

/* The factor, at most `most`. force: forces that give the load. x: a split of it, within the bounds where the factor is
 * 1 or more; those that the motion tells stay. Forces of ties that can circulate do so no harder than the load. */
double gb_load_limit(const gb_lcp *problem, const int *is_own, const gb_force_bounds *bounds, const double *force,
                     double most, double *x);

#endif
