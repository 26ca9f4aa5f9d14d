/* Why no step from the front is short enough. Knows nothing of how steps are made. */
#ifndef GB_GIVE_UP_H
#define GB_GIVE_UP_H

#include "gb_internal.h"

/* What the last try of size h said; finite: it only had too large an error. GB_DONE where the front has passed what
 * made it so. */
int gb_give_up(gb_sim *sim, int code, int finite, double h);

#endif
