/* How the event function of a condition moves by what moves already, beside a limit on which it is held:
 *     s' = s_q q' + s_t,     s'' = s_qq q' q' + 2 s_qt q' + s_tt + s_q q'' at constant speeds,     q' = H(q, t) v,
 * by differences of fourth order over time; what is no more than their rounding is none.
 * Knows nothing of forces. */
#ifndef GB_LIMIT_BEND_H
#define GB_LIMIT_BEND_H

#include "gb_internal.h"

/* s', s'' and s of event function i in the present modes at lane `lane` of `at`, as the state y moves along rates f of
 * the coordinates, so closely that they are told within a step h; admitted: an error of s' in that step (0: any). */
void gb_limit_bend(gb_sim *sim, int i, const double *f, const gb_lanes *at, int lane, const double *y, double h,
                   double admitted, double bend[3]);

/* 0 as long as the limit of the switch that slides as number j stands where it rests or is held, at the time terms at
 * hand and the state y; else -1 or 1, to which side of it the state goes: farther than its reach, or, where speed says,
 * one that is
 * held faster than is admitted; of one that slides at events alone. */
int gb_limit_moves(gb_sim *sim, int j, const double *y, int speed);

#endif
