/* Stages of a Rosenbrock step of  E x' = G(t, s, x),  s' = B x,  with y = [s | others], x = [others | massless
 * speeds]:
 *     (I - g J) K = gamma r,   g = gamma h,   is   S K_x = gamma (E r_x + g dG/ds r_s),   K_s = gamma r_s + g B K_x
 * with the step matrix S = E - g dG/dx - g^2 dG/ds B (see gb_model.h; the massless rows of E and r are zero). With
 * active constraints G v = 0, S K_x = ... + G' lambda and G K_v as the motion asks: lambda through G S^-1 G'.
 * Assumed: f(t, y0) in k1; fixed modes. df/dt along the tangent of the time terms, which all instants of the step tell.
 * Quadratures take no part, they follow by the formula of two nodes (points of the step) afterwards. Source: Hairer and
 * Wanner 1996, section IV.7; the tables carry their own (rosenbrock.py). Knows nothing of step sizes, error weights and
 * events. */
#ifndef GB_ROSENBROCK_H
#define GB_ROSENBROCK_H

#include "gb_internal.h"

/* Which speeds enter the rate of each kinematic state, B of gb_model.h: for every colour of speeds one entry of each
 * row. */
void gb_kinematic_links(gb_sim *sim);

/* Least scales of the speeds: the least way of a coordinate that a speed drives, as far as it ever came, over the gain;
 * by entry of y, 0 where there is none. Over the time so far it is a speed that cannot have mattered yet. Scales grow,
 * so that old values are safe. */
void gb_least_scales(gb_sim *sim);

/* How far along the tangent in time rates are taken for their slope: rounding of the rates is 2 h over it there. */
double gb_rosenbrock_time_step(double from, double h);

/* More instants, in the lanes behind those of the stages: for the tangent in time, and along it. */
int gb_rosenbrock_lanes(const gb_sim *sim, double from, double h, double *t);

/* All stages of the step from y0, and the n new states in z. */
int gb_rosenbrock_stages(gb_sim *sim, double h);

/* The rates at the nodes of the quadrature, and the quadratures of z. */
void gb_rosenbrock_quadratures(gb_sim *sim, double h);

/* What a small change of the rates does to the states within a step, as a rate: stiff parts do not follow it. */
void gb_rosenbrock_response(gb_sim *sim, double *change);

#endif
