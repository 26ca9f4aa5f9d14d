/* GB_AUTO: which method takes the next step. Decides by counts and step sizes alone, never by a clock.
 *
 * While an explicit method runs, the fastest vibration of the train is estimated now and then from the diagonal of the
 * step matrix. Where recent steps are near the limit of stability, or far below what even that vibration asks for, a
 * few implicit steps are tried; if they get long enough to pay, the implicit method stays. It goes when explicit steps
 * at the limit of stability would be cheaper. What a change must pay grows with recent changes, so that near
 * break-even there are few of them. Where very many steps are still to come, a trial is made whatever the reason of
 * their size, the sooner the more they are. It is made before its time where the error would let steps be longer by far
 * than the explicit method reaches: what had to be followed has died away. Where that many steps are to come that the
 * run would hardly end, one of them is a large implicit step over vibrations whose energy is nothing beside that of the
 * train. Every try that fails and every change back makes the next look come later.
 *
 * Fastest rate: roots of  m s^2 + a s + b = 0  of single unknowns, from the diagonals of E - g dG/dx - g^2 dG/ds B at
 * three g. Stability limits: Hairer and Wanner 1996, IV.2; error of a large implicit step smoothed once more: IV.8.
 *
 * Knows nothing of what the states are. */
#ifndef GB_METHOD_CHOICE_H
#define GB_METHOD_CHOICE_H

#include "gb_internal.h"

/* At the start of a run. */
void gb_choice_start(gb_sim *sim);

/* log2 of the error of a large implicit step in units of the tolerance: its estimate, smoothed once more, so that what
 * the step damps does not count (Hairer and Wanner 1996, section IV.8); too large where the energy that is dropped is
 * seen at that tolerance. */
double gb_large_step_error(gb_sim *sim, double h);

/* A step of a trial is rejected; h as above, and the step size to go on with. */
double gb_choice_rejected(gb_sim *sim, double h);

/* At the front, before a step that may reach up to `limit`. */
int gb_choice_look(gb_sim *sim, double limit);

#endif
