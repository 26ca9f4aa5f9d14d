#include "gb_tangent_parameter.h"
#include "gb_constraint_state.h"
#include "gb_modes.h"
#include "gb_rates.h"
#include "gb_time_terms.h"

static const double FURTHER = 8.0; /* times as far back, from where a time switch is followed */
static const double AS_FAR = 1e-6; /* of what an instant moves between the points: its mean may be off */
static const double LONG = 1e3;    /* times of the run: no further back than that */

/* Parameters and modes that the run has put aside. */
typedef struct gb_own {
    double *par, *mode;
} gb_own;

/* The laws are read with the parameters of a point of the difference, in the modes of the run. */
static gb_own enter(gb_sim *sim, const gb_tangent_room *room, int point) {
    const gb_own own = {sim->par, sim->mode};
    const size_t modes = (size_t)(sim->model->n_switches + sim->model->n_active_set);
    memcpy(room->mode[point], sim->mode, sizeof(double) * modes);
    sim->par = room->par[point];
    sim->mode = room->mode[point];
    if (gb_some_active(sim)) {
        sim->model->renew_active_set(sim->par, sim->mode);
    }
    return own;
}

static void leave(gb_sim *sim, gb_own own) {
    sim->par = own.par;
    sim->mode = own.mode;
}

static void move(const gb_sim *sim, const double *change, double distance, double *par) {
    for (int i = 0; i < sim->model->n_parameters; i++) {
        par[i] += distance * change[i];
    }
    sim->model->prepare(par);
}

void gb_parameter_points(const gb_sim *sim, const double *change, const gb_tangent_room *room) {
    for (int p = 0; p < GB_BESIDE; p++) {
        memcpy(room->par[p], sim->par, sizeof(double) * (size_t)sim->model->n_parameters);
        move(sim, change, gb_beside(p) * GB_PARAMETER_REACH, room->par[p]);
    }
}

void gb_parameters_moved(gb_sim *sim, const double *change, double distance) {
    move(sim, change, distance, sim->par);
    sim->panel.known = 0;
    if (gb_some_active(sim)) {
        sim->model->renew_active_set(sim->par, sim->mode);
    }
    if (sim->model->n_switches > 0) {
        gb_mode_limits(sim);
    }
}

int gb_parameter_terms(gb_sim *sim, const gb_tangent_room *room, const gb_lanes *stages, int count) {
    int code = GB_DONE;
    for (int p = 0; p < GB_BESIDE && code == GB_DONE; p++) {
        gb_lanes lanes = room->beside[p];
        memcpy(lanes.t, stages->t, sizeof(double) * (size_t)count);
        memcpy(lanes.u, stages->u, sizeof(double) * (size_t)(GB_LANES * sim->model->n_inputs));
        const gb_own own = enter(sim, room, p);
        code = gb_time_terms(sim, count, &lanes);
        leave(sim, own);
    }
    return code;
}

void gb_rates_by_parameter(gb_sim *sim, const gb_tangent_room *room, int lane, const double *y, double *out) {
    for (int p = 0; p < GB_BESIDE; p++) {
        const double weight = gb_beside_weight(p) / GB_PARAMETER_REACH;
        const gb_own own = enter(sim, room, p);
        gb_rates(sim, 0, &room->beside[p], lane, y, room->rates);
        leave(sim, own);
        for (int i = 0; i < sim->model->n; i++) {
            out[i] += weight * room->rates[i];
        }
    }
    sim->head->counts.rhs_calls += GB_BESIDE;
}

int gb_surfaces_by_parameter(gb_sim *sim, const gb_tangent_room *room, double t, const double *y, double *out) {
    const gb_model *model = sim->model;
    int code = GB_DONE;
    for (int p = 0; p < GB_BESIDE && code == GB_DONE; p++) {
        const gb_own own = enter(sim, room, p);
        code = gb_time_terms_at(sim, t);
        model->event_functions(sim->par, sim->mode, sim->instant.time_terms, y, room->functions);
        model->mode_limits(sim->par, sim->mode, room->lo, room->hi);
        leave(sim, own);
        for (int i = 0; i < model->n_event_functions; i++) {
            const double limit = sim->events.pending[i] < 0.0 ? room->lo[i] : room->hi[i];
            const int is_met = fabs(sim->events.pending[i]) == 1.0 && fabs(limit) < HUGE_VAL;
            out[i] += is_met ? gb_beside_weight(p) / GB_PARAMETER_REACH * (room->functions[i] - limit) : 0.0;
        }
    }
    return code == GB_DONE ? gb_time_terms_at(sim, t) : code;
}

/* A wave comes to its crossing again and again, and a line is beyond it: it is followed from as shortly before as its
 * crossings at all points lie around this one. */
double gb_instant_by_parameter(const gb_sim *sim, const gb_tangent_room *room, int i) {
    const double t = sim->head->front.t1, rounding = 100.0 * gb_rounding(t, sim->head->front.h);
    for (double back = rounding; back < LONG * (fabs(t) + sim->head->front.h); back *= FURTHER) {
        double mean = 0.0, slope = 0.0, far = 0.0, after;
        for (int p = 0; p < GB_BESIDE; p++) {
            const double at = sim->model->next_time(room->par[p], i, sim->mode[i], t - back, &after) - t;
            mean += (p == 0 || p == GB_BESIDE - 1 ? -1.0 : 4.0) / 6.0 * at;
            slope += gb_beside_weight(p) / GB_PARAMETER_REACH * at;
            far = gb_max(far, fabs(at));
        }
        if (far < HUGE_VAL && fabs(mean) <= AS_FAR * far + rounding) {
            return slope;
        }
    }
    return NAN;
}
