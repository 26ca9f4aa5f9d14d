/* Swings about the limit of a condition, from flip to flip: what goes back and forth at an instant slides,
 * what swings ever less comes to rest there. Where losses take ever less of them than rounding adds, swings
 * settle: their shortest becomes no shorter. Those that nothing tells any more end so: at rest, or, after so many, the
 * run stops by their name.
 * Knows nothing of how a limit is reached and held. */
#ifndef GB_SWINGS_H
#define GB_SWINGS_H

#include "gb_internal.h"

/* Counts a flip of switch i; one that goes back and forth at the front slides from here on if both sides drive it back.
 */
int gb_count_flip_or_slide(gb_sim *sim, int i);

#endif
