/* Modes of the switches: set and hashed one by one, flips counted, and when time changes them. How finely instants and
 * limits are told apart.
 * Knows nothing of what a mode does to the motion. */
#ifndef GB_MODES_H
#define GB_MODES_H

#include "gb_internal.h"

/* How finely an instant can be told near t in a step of size h. */
static inline double gb_rounding(double t, double h) {
    return 100.0 * DBL_EPSILON * (fabs(t) + fabs(h));
}

/* How far beyond a limit switch i may go by rounding. A state that comes to rest on the limit of a continuous law moves
 * by the rounding of rates that cancel: each flip without progress of time doubles it, until the next that stands
 * alone. */
static inline double gb_limit_rounding(const gb_sim *sim, int i, double limit) {
    const double start = fabs(sim->events.s0[i]);
    const double size = start < HUGE_VAL ? start : 0.0; /* where log(0) has led is told as well as the limit is */
    const double rounding = 64.0 * DBL_EPSILON * (size + fabs(limit));
    return sim->events.flips[i] > 1.0 ? ldexp(rounding, (int)sim->events.flips[i] - 1) : rounding;
}

/* Gives switch i its mode; with `log` that is an event. */
void gb_set_mode(gb_sim *sim, int i, double mode, int log);

/* The limits of all event functions in the present modes; those that are held or that slide have none, nor
 * has a friction that rests on one (gb_rates.h). */
void gb_mode_limits(gb_sim *sim);

/* Limit `side` of event function i is not watched until `time`. */
void gb_hold_limit(gb_sim *sim, int i, double side, double time);

/* Segments of tables over sizes of slips, where these have just been given directions (the start) or are others (an
 * impact), before a law is read on a segment far from them. Time terms are those of `instant`. */
void gb_modes_at_slips(gb_sim *sim, int log);

/* The hash of all modes anew. */
void gb_rehash(gb_sim *sim);

/* Switch i has flipped at this very instant, as far as time is told. */
int gb_flips_at_front(const gb_sim *sim, int i);

/* A switch may flip again at once a few times, not for ever. */
int gb_count_flip(gb_sim *sim, int i);

/* The switch of the state that flipped last, if hardly any time has passed since then; else -1. */
int gb_flipped_just_now(const gb_sim *sim);

/* Mode of switch i on the far side of the limit that it leaves through. */
double gb_far_side(const gb_sim *sim, int i, double side);

/* The next instant that time switches and tables announce. With `all`, or else only where the last one has come. */
void gb_refresh_breaks(gb_sim *sim, int all);

/* Modes of the time switches just after the front, and what they announce. */
void gb_time_modes(gb_sim *sim, int log);

/* The front has reached an announced instant. */
void gb_mark_time_events(gb_sim *sim);

/* Without location: modes follow their event functions at the end of the step, at once where no state and no constraint
 * does, else as an event. */
int gb_mark_modes(gb_sim *sim);

#endif
