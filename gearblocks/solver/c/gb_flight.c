#include "gb_flight.h"
#include "gb_constraint_state.h"
#include "gb_limit_noise.h"
#include "gb_modes.h"
#include "gb_tolerance.h"
#include "gb_vector.h"

/* Squares of restitutions beyond which impacts do not end a cascade by themselves. */
static const double MOST_KEPT = 0.999;

/* Impacts on a stop from which on they are low where their energy is; and of those that fade. */
static const double MANY = 1e5, FADING = 2e3;

/* Of the speed of half as many impacts or fewer: they fade, and come without an end. */
static const double FADED = 0.75;

/* A flight of such a duration and height cannot be told from rest: its end lies within the rounding of time, or is
 * located no better than the rounding of the gap and would give back the speed that the impact took. Where the search
 * told the gap less finely, each flight ends as much lower, and impacts that lose little keep what that gives. */
static int is_nothing(gb_sim *sim, int i, double duration, double height, double restitution) {
    const gb_head *head = sim->head;
    const int gap = sim->model->constraints[i].slip;
    const double kept = gb_min(restitution * restitution, MOST_KEPT), noise = sim->panel.noise[gap];
    return duration <= 64.0 * gb_rounding(head->front.t1, head->front.h) || height <= 2.0 * noise / (1.0 - kept) ||
           gb_is_noise(sim, gap, height, sim->instant.time_terms, sim->y, sim->y);
}

/* Flights from a stop that takes next to nothing have no end where the motion between them loses energy, or the load
 * grows: they become lower and as many more. Such a speed and height are less than what the tolerance admits of both
 * sides of the stop: the run cannot tell them from rest, nor in which of the flights it is. After N of them it cannot
 * tell the latter of N times that speed either, and takes rest where their energy is less than the tolerance too; of
 * those that do not fade, and have an end with the run, only where that would be far. Sides that have hardly moved have
 * tolerances as small: after as many impacts as count where they fade, what is less than that of the fastest in the
 * train is rest too. */
static int cannot_be_told(gb_sim *sim, int i, double speed, double height, double restitution) {
    const double impacts = sim->constraints.impacts[i], slow = gb_min(impacts, 1.0 / sqrt(sim->head->options.rtol));
    const int many = impacts >= (speed < FADED * sim->constraints.impact_speed[2 * i + 1] ? FADING : MANY);
    const double fastest = sim->head->options.rtol * gb_largest_speed(sim, sim->control.largest);
    const double of_train = impacts >= FADING ? fastest * sim->constraints.row_size[i] : 0.0;
    return restitution * restitution > MOST_KEPT &&
           speed <= (many ? slow : 1.0) * gb_max(of_train, gb_tolerance_of_slip(sim, i)) &&
           height <= gb_tolerance_of(sim, sim->model->constraints[i].slip);
}

/* How the gap of stop i, which is open, accelerates: what presses it is below zero. */
static double gap_acceleration(gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    double *rate = sim->constraints.free_acceleration;
    model->rhs(sim->par, sim->mode, sim->instant.time_terms, sim->y, sim->z2);
    sim->head->counts.rhs_calls++;
    model->slips(sim->par, sim->mode, sim->instant.time_terms, sim->y, sim->z2, rate);
    return rate[i];
}

double gb_restitution(gb_sim *sim, int i) {
    const double given = sim->constraints.bounds[5 * i + 2], speed = given * fabs(sim->constraints.slip[i]);
    if (!(given > 0.0)) {
        return given;
    }
    const double push = -gap_acceleration(sim, i), height = 0.5 * speed * speed / push;
    const int rests = push > 0.0 && (is_nothing(sim, i, 2.0 * speed / push, height, given) ||
                                     cannot_be_told(sim, i, speed, height, given));
    return rests ? 0.0 : given;
}

/* What pressed stop i, or presses it since it has been struck here and has come to rest: as an acceleration. */
static double push_on(gb_sim *sim, int i) {
    const gb_delassus W = gb_delassus_of(sim);
    if (gb_is_active(sim, i)) {
        return sim->constraints.force_before[i] * gb_delassus_diagonal(&W, i);
    }
    return sim->constraints.struck[i] == GB_STRUCK_TO_REST ? -gap_acceleration(sim, i) : 0.0;
}

int gb_ends_for_nothing(gb_sim *sim, int i) {
    const double speed = -sim->constraints.slip[i], push = -gap_acceleration(sim, i);
    return push > 0.0 && is_nothing(sim, i, 2.0 * speed / push, 0.5 * speed * speed / push, 0.0);
}

int gb_opens_for_nothing(gb_sim *sim, int i) {
    const double slip = sim->constraints.slip[i], push = push_on(sim, i);
    return push > 0.0 &&
           is_nothing(sim, i, 2.0 * slip / push, 0.5 * slip * slip / push, sim->constraints.bounds[5 * i + 2]);
}

int gb_is_being_left(gb_sim *sim, int i) {
    const gb_model *model = sim->model;
    const double slip = sim->constraints.slip[i];
    double largest = 0.0;
    if (!gb_is_stop(sim, i) || gb_is_active(sim, i) || fabs(slip) > sim->constraints.slip_rounding[i] ||
        (sim->events.pending[model->constraints[i].slip] != 0.0 && !sim->constraints.struck[i]) ||
        !(sim->head->front.t1 > sim->head->front.t_start)) {
        return 0;
    }
    const double rate = gap_acceleration(sim, i);
    for (int j = model->n - model->n_speeds; j < model->n; j++) {
        largest = gb_max(largest, fabs(sim->z2[j]));
    }
    return rate > 1e-9 * largest * sim->constraints.row_size[i];
}
