/* Angles of an implicit step whose rate is a speed among the states, phi' = w, over the stages K_j of that speed. With
 * the dense polynomial y0 + th (R_1 + (1 - th) (R_2 + th (R_3 + (1 - th) R_4))):
 *     R_1 = h w0 + h^2 sum_j g_1j K_j(w),    R_m = h^2 sum_j g_mj K_j(w)
 * These are the stages that the angle would have as a state (g follows from the tables: rosenbrock.py). So the
 * difference of two angles is the relative angle that is a state between them, at every step size, and which of them
 * is the one that is integrated makes no difference. Assumed: the stages of the step just computed.
 * Knows nothing of wrap counts and of quadratures that are no angles. */
#ifndef GB_IMPLICIT_ANGLES_H
#define GB_IMPLICIT_ANGLES_H

#include "gb_internal.h"

/* R_m of the angle whose speed is state `speed`, without h w0. */
double gb_angle_bend(const gb_sim *sim, int m, int speed, double h);

/* The angles among the quadratures at theta of a step of size h, into y. */
void gb_implicit_angles(const gb_sim *sim, double theta, double h, double *y);

/* Their rows of the dense polynomial. */
void gb_implicit_angle_rows(gb_sim *sim);

#endif
