/* The first event inside a step: the affine event functions, those with enclosures, and all others, less what is noise
 * of held speeds. Knows nothing of what an event does. */
#ifndef GB_LOCATE_H
#define GB_LOCATE_H

#include "gb_internal.h"

/* The first event inside the step just computed, as theta (2: none); all switches that flip there are marked. */
int gb_locate(gb_sim *sim, double *theta);

#endif
