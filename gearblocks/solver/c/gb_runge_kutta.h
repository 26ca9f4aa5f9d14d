/* Stages of an explicit Runge-Kutta step of y' = f(t, y):
 *     k_j = f(t + c_j h, y0 + h sum_{i<j} a_ji k_i),   z = y0 + h sum_j b_j k_j.
 * Assumed: k[0] = f(t, y0), the time terms of all stages, fixed modes: f is smooth within the step (without location:
 * the modes of each stage). Quadratures are computed at those stages only that the method reads them at. The tables
 * carry their sources (methods.py).
 * Knows nothing of errors, step sizes and events. */
#ifndef GB_RUNGE_KUTTA_H
#define GB_RUNGE_KUTTA_H

#include "gb_internal.h"

/* All stages of the step from y0, and the new state z with its quadratures. */
void gb_run_stages(gb_sim *sim, double h);

/* The stages that only dense output needs. */
void gb_run_extra_stages(gb_sim *sim, double h);

/* The same without location: every stage on the modes of its own state. */
void gb_run_stages_unlocated(gb_sim *sim, double h);
void gb_run_extra_stages_unlocated(gb_sim *sim, double h);

#endif
