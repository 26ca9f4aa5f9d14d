/* Noise of an event function: what the rounding of the states does to it,
 *     64 eps sum_j |ds/dy_j| |y_j|,   by differences, and no less than the smallest number with all its digits.
 * An angle that is the difference of coordinates, and a speed that an active constraint holds at the limit of a switch
 * (that of a planetary's braked sun, say) differ from the limit by this alone, and the sign tells nothing. Where the
 * speed is a state itself, the noise is that of the forces and has no such bound: what reads held slips alone cannot
 * leave a limit that lies so close at all. Knows nothing of modes. */
#ifndef GB_LIMIT_NOISE_H
#define GB_LIMIT_NOISE_H

#include "gb_internal.h"

/* More than all noise of an event function of such states and of their rates, at first sight. */
double gb_beyond_noise(const gb_sim *sim, const double *y, const double *other);

/* `distance` is beyond all noise of an event function of such states and of their rates, at first sight. */
int gb_is_far(const gb_sim *sim, double distance, const double *y, const double *other);

/* Event function i is off its limit by no more than noise, `distance`; the states are y
 * or, where these are larger, `other`. */
int gb_is_noise(gb_sim *sim, int i, double distance, const double *time_terms, const double *y, const double *other);

/* The same by what the noise of the rates makes of the states y within the step at hand: a body that nothing loads,
 * beside locks that carry everything, moves by this alone, and its own speed is no measure of that. */
int gb_is_noise_of_rates(gb_sim *sim, int i, double distance, const double *time_terms, const double *y);

#endif
