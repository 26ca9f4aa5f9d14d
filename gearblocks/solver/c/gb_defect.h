/* The defect of the dense output, y'(th) - f(t, y(th)) at one point inside a step: it sees what a law does between the
 * stages (Enright 1989). Asked for where a step has grown beyond those that were looked at, and where it moves a narrow
 * feature of a law: few states bend there, and an embedded estimate passes zero by chance.
 * Of implicit methods the defect is integrated, by the formula of the quadratures, and answered by the step matrix:
 *     (I - gamma h J)^-1 (y0 + h sum_i w_i f(y_i) - y1)
 * Assumed: for these the rates at the nodes, which trains with quadratures have.
 * Knows nothing of events. */
#ifndef GB_DEFECT_H
#define GB_DEFECT_H

#include "gb_features.h"
#include "gb_reach.h"

/* A step of size h is so much longer than those that were looked at (by a fifth) that it is to be looked at itself, or
 * it moves a feature, or it is held back by the reach of the method: such steps do not grow while what they follow
 * does, and are looked at the sooner the more was found. */
static inline int gb_defect_is_due(const gb_sim *sim, double h) {
    const gb_head *head = sim->head;
    const int held = head->counts.steps >= head->control.defect_at && gb_is_held_by_reach(sim, h);
    return (h > 1.2 * head->control.h_trusted || held || gb_moves_feature(sim, h)) && head->options.locate;
}

/* log2 of the error inside a step that is longer than those before, by the defect of its dense polynomial. */
double gb_log_defect(gb_sim *sim, double h);

/* Slope of the dense polynomial and h times the rates at theta, behind each other in `events.defect`: not in the last
 * row of the stages, of which the dense output of the quadratures is still made. 0: the inputs cannot be had. */
int gb_slopes_at(gb_sim *sim, double theta, double h);

/* The largest of d in tolerances, each less the rounding of a slope (rows have coefficients of some hundreds). */
double gb_largest_defect(const gb_sim *sim, const double *d, double h);

#endif
