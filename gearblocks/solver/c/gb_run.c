#include "gb_run.h"
#include "gb_dense_output.h"
#include "gb_departed.h"
#include "gb_departure.h"
#include "gb_event.h"
#include "gb_growth.h"
#include "gb_progress.h"
#include "gb_quantity.h"
#include "gb_rates.h"
#include "gb_record.h"
#include "gb_report.h"
#include "gb_sliding_outputs.h"
#include "gb_start.h"
#include "gb_step.h"
#include "gb_time_terms.h"
#include "gb_vector.h"
#include "gb_watch.h"

#include <limits.h>
#include <time.h>

enum { STEPS_BETWEEN_LOOKS = 64 }; /* at the clock */

/* Changes that wait, and whether the run can go on at all. */
static int begin(gb_sim *sim) {
    if (!sim->head->started) {
        return sim->head->report.code != GB_DONE ? sim->head->report.code : gb_fail(sim, GB_ERR_STATE, 0, 0.0, 0.0);
    }
    return gb_apply_changes(sim);
}

/* An event that is pending at the front. */
static int event(gb_sim *sim, double target) {
    const int timed = sim->head->front.t1 >= sim->head->events.t_break;
    int code = gb_apply_event(sim);
    if (code == GB_DONE) {
        code = gb_depart(sim, GB_AT_EVENT, timed);
    }
    return code == GB_DONE ? gb_progress_of_events(sim, target) : code;
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

int gb_move(gb_sim *sim, double target) {
    return move(sim, target);
}

int gb_advance_within(gb_sim *sim, double t, long moves) {
    gb_head *head = sim->head;
    int code = begin(sim);
    head->events.target = t;
    while (code == GB_DONE && (head->front.t1 < t || (head->front.t1 == t && head->events.pending))) {
        if (moves-- <= 0) {
            head->front.t_comm = head->front.t1;
            return GB_PAUSE;
        }
        code = moves % STEPS_BETWEEN_LOOKS == 0 ? gb_watch_pace(sim, t) : GB_DONE;
        code = code == GB_DONE ? move(sim, t) : code;
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

/* State, modes, time terms and derivative at the communication point: z, `mode`, `instant` and z2. */
static int at_communication_point(gb_sim *sim, const double **mode) {
    int code = gb_state(sim, sim->z);
    if (code == GB_DONE) {
        code = gb_time_terms_at(sim, sim->head->front.t_comm);
    }
    if (code == GB_DONE) {
        code = gb_modes_between(sim, sim->head->front.t_comm, sim->z, mode);
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
    if (record->n_rows >= record->row_capacity) {
        return GB_FULL;
    }
    const int code = gb_write_row(sim, t, record->rows + (size_t)record->n_rows * gb_row_length(sim->model));
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

/* The row of the front, or of t_end where the front is beyond; answers as write_samples. */
static int write_front(gb_sim *sim, double t_end, gb_record *record) {
    gb_head *head = sim->head;
    if (head->front.t1 > t_end) {
        return head->front.t_comm < t_end ? write_row(sim, record, t_end) : GB_DONE;
    }
    if (head->front.row_due) {
        const int code = write_row(sim, record, head->front.t1);
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
    sim->head->events.target = target;
    if (code == GB_DONE && record->watches && sim->head->counts.steps + sim->head->counts.events == 0) {
        code = gb_watches_take(sim, record->watches, 0);
    }
    while (code == GB_DONE) {
        if (!flush(sim, record)) {
            return GB_FULL;
        }
        code = t_out ? write_samples(sim, t_out, n_out, record) : write_front(sim, t_end, record);
        if (code != GB_PAUSE) {
            return code;
        }
        if (++count % STEPS_BETWEEN_LOOKS == 0) {
            if (slice > 0.0 && clock() >= until) {
                return GB_PAUSE;
            }
            code = gb_watch_pace(sim, target);
            if (code != GB_DONE) {
                break;
            }
        }
        const int is_step = !sim->head->events.pending;
        code = move(sim, target);
        if (code == GB_DONE && record->quantities) {
            code = gb_quantities_take(sim, record->quantities, is_step);
        }
        if (code == GB_DONE && record->watches) {
            code = gb_watches_take(sim, record->watches, is_step);
        }
    }
    flush(sim, record);
    return code;
}
