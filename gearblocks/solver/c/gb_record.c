#include "gb_record.h"
#include "gb_constraint_state.h"
#include "gb_dense_output.h"
#include "gb_inputs.h"
#include "gb_rates.h"
#include "gb_sliding_outputs.h"
#include "gb_stage_modes.h"
#include "gb_time_terms.h"

size_t gb_row_length(const gb_model *m) {
    return (size_t)(1 + m->n_total + m->n_switches + m->n_inputs);
}

int gb_modes_between(gb_sim *sim, double t, const double *y, const double **mode) {
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

int gb_write_row(gb_sim *sim, double t, double *row) {
    const gb_model *m = sim->model;
    const double *mode = sim->mode;
    int code = GB_DONE;
    *row++ = t;
    if (t >= sim->head->front.t1) { /* with few calls, as every step is watched */
        memcpy(row, sim->y, sizeof(double) * (size_t)m->n_total);
    } else {
        code = gb_dense_quadratures(sim);
        if (code != GB_DONE) {
            return code;
        }
        gb_dense_all(sim, t, row);
        code = gb_modes_between(sim, t, row, &mode);
    }
    row += m->n_total;
    memcpy(row, mode, sizeof(double) * (size_t)m->n_switches);
    if (code == GB_DONE && sim->head->events.n_sliding > 0) {
        code = gb_time_terms_at(sim, t);
        gb_mode_with_shares(sim, &sim->instant, 0, row - m->n_total, row);
    }
    return code == GB_DONE && m->n_inputs > 0 ? gb_input_values(sim, t, row + m->n_switches) : code;
}

/* Whether modes are the same numbers. */
static int are_same(const double *one, const double *other, int n) {
    for (int i = 0; i < n; i++) {
        if (one[i] != other[i]) {
            return 0;
        }
    }
    return 1;
}

/* How many rows from this one on share its modes, at most GB_LANES. */
static int same_modes(const gb_model *m, const double *row, long left) {
    const size_t length = gb_row_length(m);
    const int most = left < GB_LANES ? (int)left : GB_LANES;
    const double *mode = row + 1 + m->n_total, *other = mode + length;
    int count = 1;
    while (count < most && are_same(mode, other, m->n_switches)) {
        other += length;
        count++;
    }
    return count;
}

/* The first and the last one of those that are picked. */
static void range_of(const gb_model *m, const int *pick, int n_pick, int *first, int *last) {
    *first = m->n_outputs;
    *last = -1;
    for (int j = 0; j < n_pick; j++) {
        *first = pick[j] < *first ? pick[j] : *first;
        *last = pick[j] > *last ? pick[j] : *last;
    }
}

/* Outputs first .. last at least, in modes with their active set; dy: the rates there, or NULL. */
static void outputs_between(gb_sim *sim, const double *mode, const double *time_terms, const double *y,
                            const double *dy, int first, int last) {
    const gb_model *m = sim->model;
    double *out = sim->scratch.outputs;
    if (m->outputs_of_state && m->outputs_of_state(sim->par, mode, time_terms, y, first, last, out)) {
        return;
    }
    if (!dy) {
        m->rhs_full(sim->par, mode, time_terms, y, sim->z2);
        dy = sim->z2;
    }
    if (m->some_outputs) {
        m->some_outputs(sim->par, mode, time_terms, y, dy, first, last, out);
    } else {
        m->outputs(sim->par, mode, time_terms, y, dy, out);
    }
}

/* The same at a recorded row, in its modes; `full` are these with their active set; shares: its modes, where they hold
 * shares, else NULL. */
static void outputs_of_row(gb_sim *sim, const double *shares, const double *full, int lane, const double *y, int first,
                           int last) {
    if (shares) {
        gb_outputs_with_shares(sim, shares, &sim->instant, lane, y, sim->scratch.outputs);
    } else {
        outputs_between(sim, full, sim->instant.time_terms + lane, y, NULL, first, last);
    }
}

void gb_outputs_now(gb_sim *sim, const double *time_terms, const double *dy, const int *pick, int n_pick, double *out) {
    int first, last;
    range_of(sim->model, pick, n_pick, &first, &last);
    outputs_between(sim, sim->mode, time_terms, sim->y, dy, first, last);
    for (int j = 0; j < n_pick; j++) {
        out[j] = sim->scratch.outputs[pick[j]];
    }
}

int gb_evaluate(gb_sim *sim, const double *rows, long n_rows, const int *pick, int n_pick, double *out,
                double *energy) {
    const gb_model *m = sim->model;
    const size_t length = gb_row_length(m);
    long r = 0;
    int first, last;
    range_of(m, pick, n_pick, &first, &last);
    if (!sim->head->started) {
        m->prepare(sim->par);
    }
    while (r < n_rows) {
        const double *row = rows + (size_t)r * length, *mode = row + 1 + m->n_total;
        const double *shares = gb_has_shares(m, mode) ? mode : NULL;
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
                outputs_of_row(sim, shares, mode, l, y, first, last);
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
