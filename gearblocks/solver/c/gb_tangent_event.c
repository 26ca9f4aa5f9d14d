#include "gb_tangent_event.h"
#include "gb_departure.h"
#include "gb_event.h"
#include "gb_rates.h"
#include "gb_snapshot.h"
#include "gb_tangent_parameter.h"
#include "gb_tangent_step.h"
#include "gb_time_terms.h"

static const double ALONG = 1e-3;     /* steps: how far along the motion a difference goes */
static const double GRAZING = 1e-4;   /* steps: a surface that is left again within less is grazed */
static const double AT_ONCE = 1e-6;   /* delays to two surfaces that differ by less are one */
static const double UNMOVED = 1e-9;   /* of the size of a state: less is no jump of it */
static const double UNCHANGED = 1e-9; /* of the size of a rate */
static const double SET = 1e-6;       /* of what lies beside: less is what a difference is off */

/* Derivative of the event functions at (t, y) along (dt, v), into out. */
static int along(gb_sim *sim, const gb_tangent_room *room, double t, const double *y, double dt, const double *v,
                 double *out) {
    const gb_model *model = sim->model;
    const int general = model->n_event_functions > model->n_affine;
    const double reach = dt > 0.0 ? ALONG * sim->head->front.h / dt : gb_tangent_reach(sim, room, y, v);
    int code = GB_DONE;
    memset(out, 0, sizeof(double) * (size_t)model->n_event_functions);
    for (int p = 0; p < GB_BESIDE && general && reach > 0.0 && code == GB_DONE; p++) {
        const double distance = gb_beside(p) * reach;
        for (int i = 0; i < model->n_padded; i++) {
            room->moved[i] = y[i] + distance * v[i];
        }
        code = gb_time_terms_at(sim, t + distance * dt);
        model->event_functions(sim->par, sim->mode, sim->instant.time_terms, room->moved, room->functions);
        for (int i = model->n_affine; i < model->n_event_functions; i++) {
            out[i] += gb_beside_weight(p) / reach * room->functions[i];
        }
    }
    if (model->n_affine > 0) {
        model->directions(sim->par, v, out);
    }
    return code;
}

void gb_tangents_note(gb_tangents *tangents, double t) {
    tangents->index = tangents->undefined ? tangents->index : tangents->surface;
    tangents->t = tangents->undefined ? tangents->t : t;
    tangents->undefined++;
}

static int is_surface(const gb_sim *sim, int i) {
    return fabs(sim->events.pending[i]) == 1.0 && !gb_slides(sim, i);
}

/* Whether the motion leaves surface i again at once: its speed there is that of a moment. */
static int grazes(gb_sim *sim, const gb_tangent_room *room, int i, double speed) {
    const double t = sim->head->front.t1, back = ALONG * sim->head->front.h;
    for (int j = 0; j < sim->model->n_padded; j++) {
        room->state[j] = room->before[j] - back * room->rates_before[j];
    }
    if (gb_time_terms_at(sim, t - back) != GB_DONE) {
        return 1;
    }
    gb_rates(sim, 0, &sim->instant, 0, room->state, room->combined);
    if (along(sim, room, t - back, room->state, 1.0, room->combined, room->surfaces) != GB_DONE) {
        return 1;
    }
    const double change = (speed - room->surfaces[i]) / back;
    return !(fabs(speed) > GRAZING * sim->head->front.h * fabs(change));
}

static void doubt(gb_tangents *tangents, int surface) {
    tangents->doubt = 1;
    tangents->surface = surface;
}

/* Column c meets what is pending by switch i so much later; motions that meet several one after the other have no
 * derivative. met: whether another one has been met. */
static void meets(gb_tangents *tangents, const gb_tangent_room *room, int c, int i, double delay, int *met) {
    const double before = room->delay[c];
    if (!(fabs(delay) < HUGE_VAL) || (*met && fabs(delay - before) > AT_ONCE * gb_max(fabs(delay), fabs(before)))) {
        doubt(tangents, i);
    }
    room->delay[c] = *met || !(fabs(delay) < HUGE_VAL) ? before : delay;
    *met = 1;
}

/* How much later the motion of column c reaches its surface, and a train with other parameters its instant. */
static int delay_of(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room, int c) {
    const gb_model *model = sim->model;
    const double *v = tangents->columns + (size_t)c * (size_t)model->n_total, t = sim->head->front.t1;
    const int by_parameter = tangents->change && c == tangents->count - 1;
    int met = 0, code = along(sim, room, t, room->before, 0.0, v, room->surfaces);
    if (by_parameter && code == GB_DONE) {
        code = gb_surfaces_by_parameter(sim, room, t, room->before, room->surfaces);
    }
    for (int i = 0; i < model->n_event_functions && code == GB_DONE; i++) {
        if (is_surface(sim, i)) {
            meets(tangents, room, c, i, room->speeds[i] != 0.0 ? -room->surfaces[i] / room->speeds[i] : 0.0, &met);
        }
    }
    for (int i = model->n_event_functions; i < model->n_switches && by_parameter && code == GB_DONE; i++) {
        if (sim->events.pending[i] != 0.0) {
            meets(tangents, room, c, i, gb_instant_by_parameter(sim, room, i), &met);
        }
    }
    return code;
}

/* How much later each motion beside reaches its surface. */
static int delays(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room) {
    int code = along(sim, room, sim->head->front.t1, room->before, 1.0, room->rates_before, room->speeds);
    for (int i = 0; i < sim->model->n_event_functions && code == GB_DONE; i++) {
        if (is_surface(sim, i) && grazes(sim, room, i, room->speeds[i])) {
            doubt(tangents, i);
        }
    }
    for (int c = 0; c < tangents->count && code == GB_DONE; c++) {
        code = delay_of(sim, tangents, room, c);
    }
    return code;
}

int gb_tangents_before(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room) {
    int surfaces = 0;
    for (int i = 0; i < sim->model->n_event_functions; i++) {
        surfaces += is_surface(sim, i);
    }
    tangents->doubt = 0;
    tangents->surface = -1;
    gb_copy(room->before, sim->y, sim->model->n_total);
    int code = gb_time_terms_at(sim, sim->head->front.t1);
    gb_rates(sim, 0, &sim->instant, 0, sim->y, room->rates_before);
    memset(room->delay, 0, sizeof(double) * (size_t)tangents->count);
    if (code == GB_DONE && (surfaces > 0 || tangents->change)) {
        code = delays(sim, tangents, room);
    }
    sim->head->front.t_comm = sim->head->front.t1;
    gb_save(sim, room->block_before);
    return code;
}

/* Whether the event has changed states, or rates. */
static int has_changed(const gb_sim *sim, const double *before, const double *after, double least, int rates) {
    for (int i = 0; i < sim->model->n; i++) {
        const double size = gb_max(fabs(before[i]), fabs(after[i]));
        if (fabs(after[i] - before[i]) > least * (rates ? size : gb_max(size, sim->control.largest[i]))) {
            return 1;
        }
    }
    return 0;
}

/* A train beside at its event: its state, instant and parameters (change NULL: the same). */
static void set_beside(gb_sim *sim, const double *w, double delay, const double *change, double distance) {
    struct gb_event_state *events = &sim->head->events;
    const double later = distance * delay;
    for (int i = sim->model->n_event_functions; i < sim->model->n_switches; i++) {
        sim->events.next_time[i] += sim->events.next_time[i] <= sim->head->front.t1 ? later : 0.0;
    }
    events->t_break += events->t_break <= sim->head->front.t1 ? later : 0.0;
    sim->head->front.t1 += later;
    for (int i = 0; i < sim->model->n; i++) {
        sim->y[i] += distance * w[i];
    }
    if (change) {
        gb_parameters_moved(sim, change, distance);
    }
}

/* How far it lies in a difference. */
static double reach_of(const gb_sim *sim, const gb_tangent_room *room, const double *w, double delay, int moved) {
    const double by_states = gb_tangent_reach(sim, room, room->before, w);
    const double by_time = delay != 0.0 ? ALONG * sim->head->front.h / fabs(delay) : 0.0;
    const double most = by_states > 0.0 ? by_states : by_time;
    return !moved ? most : most > 0.0 ? gb_min(most, GB_PARAMETER_REACH) : GB_PARAMETER_REACH;
}

/* R_x w + R_t dt + R_p, into beyond. Answers whether motions beside meet the event likewise. The state after it is left
 * as it was. */
static int mapped(gb_sim *sim, const gb_tangent_room *room, const double *w, double delay, const double *change) {
    const double reach = reach_of(sim, room, w, delay, change != NULL);
    const uint64_t modes = sim->head->events.mode_hash;
    int alike = 1;
    memset(room->beyond, 0, sizeof(double) * (size_t)sim->model->n_total);
    gb_save(sim, room->block_after);
    for (int p = 0; p < GB_BESIDE && reach > 0.0; p++) {
        gb_restore(sim, room->block_before);
        set_beside(sim, w, delay, change, gb_beside(p) * reach);
        const int timed = sim->head->front.t1 >= sim->head->events.t_break;
        int code = gb_apply_event(sim);
        code = code == GB_DONE ? gb_depart(sim, GB_AT_EVENT, timed) : code;
        alike = alike && code == GB_DONE && sim->head->events.mode_hash == modes;
        for (int i = 0; i < sim->model->n; i++) {
            room->beyond[i] += gb_beside_weight(p) / reach * sim->y[i];
        }
    }
    gb_restore(sim, room->block_after);
    return alike;
}

/* Whether the event, which left the state as it was, moves what lies beside by w otherwise: a state that is set takes
 * the value that it has. */
static int sets_beside(const gb_sim *sim, const gb_tangent_room *room, const double *w) {
    double most = 0.0, moved = 0.0;
    for (int i = 0; i < sim->model->n; i++) {
        most = gb_max(most, fabs(w[i]) / room->scale[i]);
        moved = gb_max(moved, fabs(room->beyond[i] - w[i]) / room->scale[i]);
    }
    return moved > SET * most;
}

int gb_tangents_after(gb_sim *sim, gb_tangents *tangents, const gb_tangent_room *room) {
    const int n = sim->model->n;
    const int code = gb_time_terms_at(sim, sim->head->front.t1);
    gb_rates(sim, 0, &sim->instant, 0, sim->y, room->rates_after);
    sim->head->front.t_comm = sim->head->front.t1;
    const int jumps = has_changed(sim, room->before, sim->y, UNMOVED, 0);
    const int bends = has_changed(sim, room->rates_before, room->rates_after, UNCHANGED, 1);
    const int sets = !jumps && sim->model->update_states;
    int moves = jumps || bends;
    for (int c = 0; c < tangents->count && (moves || sets); c++) {
        double *v = tangents->columns + (size_t)c * (size_t)sim->model->n_total;
        const double delay = room->delay[c];
        for (int i = 0; i < n; i++) {
            v[i] += delay * room->rates_before[i];
        }
        if (jumps || sets) {
            const int moved = tangents->change && c == tangents->count - 1;
            const int alike = mapped(sim, room, v, delay, moved ? tangents->change : NULL);
            if (jumps || sets_beside(sim, room, v)) {
                moves = 1;
                if (!alike) {
                    doubt(tangents, tangents->surface);
                }
                memcpy(v, room->beyond, sizeof(double) * (size_t)n);
            }
        }
        for (int i = 0; i < n; i++) {
            v[i] -= delay * room->rates_after[i];
        }
    }
    if (tangents->doubt && moves) {
        gb_tangents_note(tangents, sim->head->front.t1);
    }
    return code;
}
