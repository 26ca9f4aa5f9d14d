#include "gb_run.h"
#include "gb_constraint_state.h"
#include "gb_dense_output.h"
#include "gb_departure.h"
#include "gb_event.h"
#include "gb_inputs.h"
#include "gb_rates.h"
#include "gb_report.h"
#include "gb_sliding_outputs.h"
#include "gb_stage_modes.h"
#include "gb_start.h"
#include "gb_step.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

#include <limits.h>
#include <time.h>

enum { STEPS_BETWEEN_LOOKS = 64 }; /* at the clock */
enum { CROWD = 100000 };           /* events in a row that must bring the run on by a part of what is left of it: */
static const double LEAST_PROGRESS = 1e-5;

static size_t row_length(const gb_model *m) {
    return (size_t)(1 + m->n_total + m->n_switches + m->n_inputs);
}

/* Changes that wait, and whether the run can go on at all. */
static int begin(gb_sim *sim) {
    if (!sim->head->started) {
        return sim->head->report.code != GB_DONE ? sim->head->report.code : gb_fail(sim, GB_ERR_STATE, 0, 0.0, 0.0);
    }
    return gb_apply_changes(sim);
}

/* Limit of progress: events that follow on each other so closely that the run does not end. Named is the switch of the
 * last one. */
static int check_progress(gb_sim *sim, double target) {
    gb_head *head = sim->head;
    const long long crowd = head->counts.events - head->events.crowd;
    if (crowd < CROWD) {
        return GB_DONE;
    }
    const double progress = head->front.t1 - head->events.t_crowd;
    const int index = sim->log.count > 0 ? sim->log.event[sim->log.count - 1].index : 0;
    head->events.crowd = head->counts.events;
    head->events.t_crowd = head->front.t1;
    return progress < LEAST_PROGRESS * (target - head->front.t1)
               ? gb_fail(sim, GB_ERR_CHATTER, index, head->front.t1, (double)crowd)
               : GB_DONE;
}

/* An event that is pending at the front. */
static int event(gb_sim *sim, double target) {
    const int timed = sim->head->front.t1 >= sim->head->events.t_break;
    int code = gb_apply_event(sim);
    if (code == GB_DONE) {
        code = gb_depart(sim, 1, timed);
    }
    return code == GB_DONE ? check_progress(sim, target) : code;
}

/* A step from the front. */
static int step(gb_sim *sim, double target) {
    const int code = sim->head->front.t1 >= sim->head->events.held_until ? gb_departed(sim) : GB_DONE;
    return code == GB_DONE ? gb_step(sim, gb_max(sim->head->options.t_stop, target)) : code;
}

/* The front moves on: what is pending there, or else a step. After an error the last good front stands. */
GB_INLINE int move(gb_sim *sim, double target) {
    const int code = sim->head->events.pending ? event(sim, target) : step(sim, target);
    if (code != GB_DONE) {
        sim->head->front.t0 = sim->head->front.t1;
        sim->head->front.h = 0.0;
        sim->head->front.have_dense = sim->head->front.have_quadratures = 0;
        sim->head->front.t_comm = sim->head->front.t1;
    }
    return code;
}

int gb_advance_within(gb_sim *sim, double t, long moves) {
    gb_head *head = sim->head;
    int code = begin(sim);
    while (code == GB_DONE && (head->front.t1 < t || (head->front.t1 == t && head->events.pending))) {
        if (moves-- <= 0) {
            head->front.t_comm = head->front.t1;
            return GB_PAUSE;
        }
        code = move(sim, t);
        sim->log.count = sim->log.flushed = 0;
    }
    if (code == GB_DONE && t < head->front.t1) {
        code = gb_dense_quadratures(sim);
    }
    if (code == GB_DONE) {
        head->front.t_comm = t;
    }
    return code;
}

int gb_advance(gb_sim *sim, double t) {
    return gb_advance_within(sim, t, LONG_MAX);
}

double gb_time(const gb_sim *sim) {
    return sim->head->front.t_comm;
}

int gb_state(gb_sim *sim, double *y) {
    const int code = begin(sim);
    gb_dense_all(sim, sim->head->front.t_comm, y);
    return code;
}

/* The modes at t, where the state is y: those of the front, or without location those that fit there. */
static int modes_between(gb_sim *sim, double t, const double *y, const double **mode) {
    int code = GB_DONE;
    *mode = sim->mode;
    if (!sim->head->options.locate && t < sim->head->front.t1) {
        code = gb_time_terms_at(sim, t);
        gb_stage_modes_begin(sim, 1);
        gb_stage_modes(sim, &sim->instant, 1, 0, y);
        *mode = sim->unlocated.mode;
    }
    return code;
}

/* State, modes, time terms and derivative at the communication point: z, `mode`, `instant` and z2. */
static int at_communication_point(gb_sim *sim, const double **mode) {
    int code = gb_state(sim, sim->z);
    if (code == GB_DONE) {
        code = gb_time_terms_at(sim, sim->head->front.t_comm);
    }
    if (code == GB_DONE) {
        code = modes_between(sim, sim->head->front.t_comm, sim->z, mode);
    }
    if (code == GB_DONE) {
        sim->model->rhs_full(sim->par, *mode, sim->instant.time_terms, sim->z, sim->z2);
        if (sim->model->output_time_terms) {
            sim->model->output_time_terms(sim->par, *mode, 1, sim->instant.t, sim->instant.u, sim->instant.time_terms);
        }
    }
    return code;
}

int gb_outputs(gb_sim *sim, double *out) {
    const double *mode;
    const int code = at_communication_point(sim, &mode);
    if (code == GB_DONE && sim->head->events.n_sliding > 0) {
        memcpy(sim->unlocated.mode, mode, sizeof(double) * (size_t)sim->model->n_switches);
        gb_mode_with_shares(sim, &sim->instant, 0, sim->z, sim->unlocated.mode);
        gb_outputs_with_shares(sim, sim->unlocated.mode, &sim->instant, 0, sim->z, out);
    } else if (code == GB_DONE) {
        sim->model->outputs(sim->par, mode, sim->instant.time_terms, sim->z, sim->z2, out);
    }
    return code;
}

int gb_energies(gb_sim *sim, double *energy) {
    const double *mode;
    const int code = at_communication_point(sim, &mode);
    if (code == GB_DONE) {
        sim->model->energies(sim->par, mode, sim->instant.time_terms, sim->z, energy);
    }
    return code;
}

int gb_rhs(gb_sim *sim, double t, const double *y, double *dy) {
    const int code = gb_time_terms_at(sim, t);
    if (code == GB_DONE) {
        sim->model->rhs_full(sim->par, sim->mode, sim->instant.time_terms, y, dy);
    }
    return code;
}

/* Moves waiting events into the record; 0 when it is full. */
static int flush(gb_sim *sim, gb_record *record) {
    while (sim->log.flushed < sim->log.count) {
        if (record->n_events >= record->event_capacity) {
            return 0;
        }
        record->events[record->n_events++] = sim->log.event[sim->log.flushed++];
    }
    sim->log.count = sim->log.flushed = 0;
    return 1;
}

static int write_row(gb_sim *sim, gb_record *record, double t) {
    const gb_model *m = sim->model;
    if (record->n_rows >= record->row_capacity) {
        return GB_FULL;
    }
    if (t < sim->head->front.t1) {
        const int code = gb_dense_quadratures(sim);
        if (code != GB_DONE) {
            return code;
        }
    }
    double *row = record->rows + (size_t)record->n_rows * row_length(m);
    *row++ = t;
    gb_dense_all(sim, t, row);
    const double *mode;
    int code = modes_between(sim, t, row, &mode);
    row += m->n_total;
    memcpy(row, mode, sizeof(double) * (size_t)m->n_switches);
    if (code == GB_DONE && sim->head->events.n_sliding > 0) {
        code = gb_time_terms_at(sim, t);
        gb_mode_with_shares(sim, &sim->instant, 0, row - m->n_total, row);
    }
    if (code == GB_DONE) {
        code = gb_input_values(sim, t, row + m->n_switches);
    }
    if (code == GB_DONE) {
        record->n_rows++;
        sim->head->front.t_comm = t;
    }
    return code;
}

/* Every row that the present segment can give; GB_PAUSE: the front must move; GB_DONE: all samples are done. */
static int write_samples(gb_sim *sim, const double *t, long n, gb_record *record) {
    gb_head *head = sim->head;
    for (; head->front.sample < n; head->front.sample++) {
        const double at = t[head->front.sample];
        if (!(at < head->front.t1 || (at == head->front.t1 && !head->events.pending))) {
            return GB_PAUSE;
        }
        const int code = write_row(sim, record, gb_max(at, head->front.t0));
        if (code != GB_DONE) {
            return code;
        }
    }
    head->front.sample = 0;
    return GB_DONE;
}

/* Rows within the segment that ends at the front; at its end where it is too short for any. None after an event. */
static int write_inner(gb_sim *sim, gb_record *record) {
    const double t0 = sim->head->front.t0, t1 = sim->head->front.t1;
    const long count = sim->head->front.t_comm < t1 ? record->n_inner : 0;
    int code = GB_DONE;
    for (long i = 0; i < count && code == GB_DONE; i++) {
        const int roomy = t0 + (t1 - t0) * record->inner[0] > t0;
        code = write_row(sim, record, roomy ? t0 + (t1 - t0) * record->inner[i] : t1);
    }
    return code;
}

/* The row of the front, or of t_end where the front is beyond; answers as write_samples. */
static int write_front(gb_sim *sim, double t_end, gb_record *record) {
    gb_head *head = sim->head;
    if (head->front.t1 > t_end) {
        return head->front.t_comm < t_end ? write_row(sim, record, t_end) : GB_DONE;
    }
    if (head->front.row_due) {
        int code = record->n_rows + record->n_inner < record->row_capacity ? write_inner(sim, record) : GB_FULL;
        code = code == GB_DONE ? write_row(sim, record, head->front.t1) : code;
        if (code != GB_DONE) {
            return code;
        }
        head->front.row_due = 0;
    }
    return head->events.pending || head->front.t1 < t_end ? GB_PAUSE : GB_DONE;
}

int gb_run(gb_sim *sim, const double *t_out, long n_out, double t_end, gb_record *record, double slice) {
    const double target = t_out ? (n_out > 0 ? t_out[n_out - 1] : sim->head->front.t1) : t_end;
    const clock_t until = clock() + (clock_t)(gb_min(slice, 1e6) * CLOCKS_PER_SEC);
    int code = begin(sim), count = 0;
    while (code == GB_DONE) {
        if (!flush(sim, record)) {
            return GB_FULL;
        }
        code = t_out ? write_samples(sim, t_out, n_out, record) : write_front(sim, t_end, record);
        if (code != GB_PAUSE) {
            return code;
        }
        if (++count % STEPS_BETWEEN_LOOKS == 0 && slice > 0.0 && clock() >= until) {
            return GB_PAUSE;
        }
        code = move(sim, target);
    }
    flush(sim, record);
    return code;
}

/* How many rows from this one on share its modes, at most GB_LANES. */
static int same_modes(const gb_model *m, const double *row, long left) {
    const size_t length = row_length(m);
    const size_t bytes = sizeof(double) * (size_t)m->n_switches;
    int count = 1;
    while (count < GB_LANES && count < left &&
           (bytes == 0 || memcmp(row + 1 + m->n_total, row + (size_t)count * length + 1 + m->n_total, bytes) == 0)) {
        count++;
    }
    return count;
}

/* All outputs at a recorded row, in its modes; `full` are these with their active set. */
static void outputs_of_row(gb_sim *sim, const double *mode, const double *full, int lane, const double *y) {
    const gb_model *m = sim->model;
    if (gb_has_shares(m, mode)) {
        gb_outputs_with_shares(sim, mode, &sim->instant, lane, y, sim->scratch.outputs);
        return;
    }
    const double *time_terms = sim->instant.time_terms + lane;
    m->rhs_full(sim->par, full, time_terms, y, sim->z2);
    m->outputs(sim->par, full, time_terms, y, sim->z2, sim->scratch.outputs);
}

int gb_evaluate(gb_sim *sim, const double *rows, long n_rows, const int *pick, int n_pick, double *out,
                double *energy) {
    const gb_model *m = sim->model;
    const size_t length = row_length(m);
    long r = 0;
    if (!sim->head->started) {
        m->prepare(sim->par);
    }
    while (r < n_rows) {
        const double *row = rows + (size_t)r * length, *mode = row + 1 + m->n_total;
        const int count = same_modes(m, row, n_rows - r);
        for (int l = 0; l < GB_LANES; l++) {
            const double *at = row + (size_t)(l < count ? l : count - 1) * length;
            sim->instant.t[l] = at[0];
            for (int i = 0; i < m->n_inputs; i++) {
                sim->instant.u[i * GB_LANES + l] = at[1 + m->n_total + m->n_switches + i];
            }
        }
        if (m->n_time_terms > 0) {
            m->time_terms(sim->par, mode, count, sim->instant.t, sim->instant.u, sim->instant.time_terms);
            if (m->output_time_terms) {
                m->output_time_terms(sim->par, mode, count, sim->instant.t, sim->instant.u, sim->instant.time_terms);
            }
        }
        mode = gb_modes_with_active_set(sim, mode, sim->instant.time_terms, row + 1);
        for (int l = 0; l < count; l++, r++) {
            const double *y = rows + (size_t)r * length + 1, *time_terms = sim->instant.time_terms + l;
            if (n_pick > 0) {
                outputs_of_row(sim, row + 1 + m->n_total, mode, l, y);
                for (int j = 0; j < n_pick; j++) {
                    out[(size_t)r * (size_t)n_pick + (size_t)j] = sim->scratch.outputs[pick[j]];
                }
            }
            if (energy) {
                m->energies(sim->par, mode, time_terms, y, energy + (size_t)r * (size_t)m->n_energies);
            }
        }
    }
    gb_input_broadcast(sim);
    return GB_DONE;
}
