/* Error estimates and step sizes:  err = max_i |e_i| / weight_i,   h_next = h err^(-1/p) with PI control. Error weight
 * of a state: rtol times its tolerance scale, which is the largest value it had, its natural scale, or what its rate
 * gives at first, plus h times the noise of its rate. There is no absolute tolerance: every state is measured against
 * its own history.
 * Assumed: the stages of the step just computed.
 * Sources: Hairer, Norsett and Wanner 1993, II.4 (first step, error of order 8 from two estimates: II.10); Hairer and
 * Wanner 1996, IV.2 (PI control); exp2 and log2 to about 1e-3 here.
 * Knows nothing of events. */
#ifndef GB_ERROR_CONTROL_H
#define GB_ERROR_CONTROL_H

#include "gb_internal.h"

/* Error weights 1 / (rtol scale + h noise). The tolerance scale of a state is its largest value so far, its natural
 * scale where the train knows one, and before the first step what its rate gives; never less than a small part of the
 * largest of its kind (a front that runs along a chain is not followed into its last digit). `trial` counts too where a
 * state has no scale at all. */
void gb_error_weights(gb_sim *sim, double h, const gb_lanes *at, const double *trial);

/* A trial is refused. Where the error is that of a longer trial, noise is measured once more, and doubled where it is
 * most of the tolerance. */
void gb_forget_trial(gb_sim *sim, double error);

/* Of a train with states that have no scale: one has moved without coming to a scale, or begins to move in the trial
 * step. */
int gb_begins_to_move(const gb_sim *sim);

/* Whether weights are to follow the trial step. */
static inline int gb_weights_follow_trial(const gb_sim *sim) {
    return sim->head->control.unscaled && gb_begins_to_move(sim);
}

/* Whether noise that is most of a tolerance is that of a step much longer than h. */
static inline int gb_noise_is_of_longer(const gb_sim *sim, double h) {
    return sim->head->control.noisy && h < 0.25 * sim->head->control.h_noise;
}

/* Takes the front into the tolerance scales. The error weights of an implicit method are kept until a scale is by a
 * tenth beyond what they were made for: the tolerance lags behind on the safe side. */
void gb_scales_grow(gb_sim *sim, const double *y);

/* The state whose error decided. */
int gb_worst_state(const gb_sim *sim);

/* Factor of the next step size after a step with this error (PI control: Hairer, Wanner 1996, IV.2). */
double gb_step_factor(gb_sim *sim, double log_error, int accepted);

/* A first step from the rates at the start and after a small Euler step (after Hairer, Norsett, Wanner 1993, II.4). */
double gb_first_step(gb_sim *sim);

/* log2 and exp2 to about 1e-3: enough for step sizes, quick, and the same bits on every machine. */
double gb_rough_exp2(double x);
double gb_rough_log2(double x);

/* log2 of the largest error of a state in units of its weight. */
double gb_log_error(const gb_sim *sim, double h);

#endif
