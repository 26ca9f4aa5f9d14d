/* Conditions whose quantity is exactly on its limit: a pedal at 0 that is asked for > 0, a gear number for >= 2, a
 * signal at the joint of a step table. What passes a limit is beyond it an instant later, whatever it is there; what
 * stays has the mode that the condition says.
 * Knows nothing of how limits are passed. */
#ifndef GB_EXACT_LIMIT_H
#define GB_EXACT_LIMIT_H

#include "gb_internal.h"

/* Gives what is on a limit at the front, and stays there, the mode of the limit, and what only time moves that of the
 * side to which it goes; what follows from them is to be settled. *changed: how many more. */
int gb_take_exact_modes(gb_sim *sim, int log, int *changed);

#endif
