/* The end of what a departure has held: the front has come to where a side was plain.
 * Knows nothing of how that was found. */
#ifndef GB_DEPARTED_H
#define GB_DEPARTED_H

#include "gb_internal.h"

/* Limits are watched again, but for those of which the tolerance of a step leaves no more than was known. */
int gb_departed(gb_sim *sim);

#endif
