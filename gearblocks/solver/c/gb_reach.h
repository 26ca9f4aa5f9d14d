/* How far an explicit method reaches: h |lambda| <= reach for the eigenvalue lambda of largest modulus of the Jacobian
 * J of the rates. Stable up to 6 on the negative real axis, the pair 8(5,3) tells its error up to 4 only: beyond, its
 * estimate has a zero (near -5.7) where the step control settles, and the dense polynomial is off by ten times the ends
 * of the step. Power iteration along the run, two evaluations a look:  v = J u, w = J v,  w = p v - q u in the least
 * squares, lambda the larger root of  x^2 - p x + q  (a vibration has a pair of them, which two steps of the iteration
 * tell whatever the units of angles and speeds);  u <- w for the next look, with a little of the difference of the two
 * last rates of the step, both at its end: what is fast is in it, and parts of a train that nothing couples, as long as
 * a clutch slips or a gap is open, would never come into the iteration by themselves. Source: power iteration for the
 * step size of stabilized methods: Sommeijer, Shampine and Verwer 1998; that difference to tell stiffness by: Hairer
 * and Wanner 1996, IV.2. Assumed: the stages of the step, the rates at its end, error weights. Knows nothing of why
 * a train is fast. */
#ifndef GB_REACH_H
#define GB_REACH_H

#include "gb_internal.h"

/* It is time to look at a step of size h: a look is due, or the step is twice as long as that of the last look, which
 * did not follow what it does, and not one of the first six after it. */
static inline int gb_reach_is_due(const gb_sim *sim, double h) {
    const struct gb_pace *control = &sim->head->control;
    const long long steps = sim->head->counts.steps, looked = control->reach_at - control->reach_gap;
    return sim->method->reach > 0.0 &&
           (steps >= control->reach_at || (h > 2.0 * control->reach_h && steps >= looked + 6));
}

/* log2 of the error that would shorten a step of size h to what the method reaches; -100 where it is short enough. */
double gb_log_reach(gb_sim *sim, double h);

/* h, or less where the last look says so. */
static inline double gb_reach_step(const gb_sim *sim, double h) {
    const double rate = sim->head->control.reach_rate, reach = sim->method->reach;
    return rate * h > reach && reach > 0.0 ? reach / rate : h;
}

/* A step of size h is about as long as the method reaches. */
static inline int gb_is_held_by_reach(const gb_sim *sim, double h) {
    return sim->method->reach > 0.0 && h * sim->head->control.reach_rate > 0.75 * sim->method->reach;
}

/* Modes have changed: what was found is in doubt where it was close to deciding. */
void gb_reach_changed(gb_sim *sim);

/* The modes have not been before: what was found tells nothing of them. */
void gb_reach_anew(gb_sim *sim);

#endif
