#include "gb_study.h"
#include "gb_internal.h"
#include "gb_memory.h"
#include "gb_quantity.h"
#include "gb_record.h"
#include "gb_run.h"
#include "gb_start.h"

#include <time.h>

/* Energy at the communication point. */
static int energy(gb_sim *sim, double *sum) {
    const int code = gb_energies(sim, sim->scratch.energies);
    *sum = 0.0;
    for (int i = 0; i < sim->model->n_energies; i++) {
        *sum += sim->scratch.energies[i];
    }
    return code;
}

/* Its numbers are written where the run reads them. */
static void set_point(gb_sim *sim, const gb_study *study, gb_options *options) {
    const gb_model *m = sim->model;
    const size_t point = (size_t)study->point, n_parameters = (size_t)m->n_parameters, n_inputs = (size_t)m->n_inputs;
    gb_quantities *quantities = study->record.quantities;
    memcpy(gb_parameters(sim), study->parameters + point * n_parameters, sizeof(double) * n_parameters);
    if (study->inputs) {
        memcpy(gb_inputs(sim), study->inputs + point * n_inputs, sizeof(double) * n_inputs);
    }
    *options = study->options;
    options->t_stop = study->times[(point + 1) * (size_t)study->n_times - 1];
    if (study->steps) {
        options->step = study->steps[point];
    }
    for (int j = 0; quantities && j < quantities->count; j++) {
        const double *window = study->windows + 2 * (point * (size_t)quantities->count + (size_t)j);
        quantities->of[j].after = window[0];
        quantities->of[j].before = window[1];
    }
}

static int begin(gb_sim *sim, gb_study *study) {
    const size_t point = (size_t)study->point, n_states = (size_t)study->n_states;
    const double *start = study->start;
    gb_options options;
    set_point(sim, study, &options);
    if (start && !study->lone_start) {
        start += point * (size_t)sim->model->n_total;
    }
    int code = gb_start(sim, &options, study->t0, start);
    code = code == GB_DONE ? gb_state(sim, study->first) : code;
    code = code == GB_DONE ? energy(sim, study->balance + 4 * point) : code;
    for (size_t i = 0; i < n_states && code == GB_DONE; i++) {
        study->start_states[point * n_states + i] = study->first[study->states[i]];
    }
    if (study->record.quantities) {
        gb_quantities_begin(study->record.quantities);
    }
    study->record.n_rows = study->n_done = 0;
    study->begun = 1;
    return code;
}

/* Outputs and states of the rows that are there, which are taken out of the record. */
static int evaluate(gb_sim *sim, gb_study *study) {
    const size_t length = gb_row_length(sim->model), width = (size_t)(study->n_outputs + study->n_states);
    double *values = study->values + ((size_t)study->point * (size_t)study->n_times + (size_t)study->n_done) * width;
    int code = GB_DONE;
    for (long i = 0; i < study->record.n_rows && code == GB_DONE; i++, values += width) {
        const double *row = study->record.rows + (size_t)i * length;
        if (study->n_outputs > 0) {
            code = gb_evaluate(sim, row, 1, study->outputs, study->n_outputs, values, NULL);
        }
        for (int j = 0; j < study->n_states; j++) {
            values[study->n_outputs + j] = row[1 + study->states[j]];
        }
    }
    study->n_done += study->record.n_rows;
    study->record.n_rows = 0;
    return code;
}

static int end(gb_sim *sim, gb_study *study) {
    const size_t point = (size_t)study->point;
    const gb_quantities *quantities = study->record.quantities;
    double *balance = study->balance + 4 * point;
    const int code = energy(sim, balance + 1);
    balance[2] = 0.0;
    for (int i = 0; i < study->n_ledger; i++) {
        balance[2] += study->sign[i] * (sim->y[study->ledger[i]] - study->first[study->ledger[i]]);
    }
    balance[3] = sim->head->ledger.turnover;
    for (int j = 0; quantities && j < quantities->count; j++) {
        study->quantities[point * (size_t)quantities->count + (size_t)j] = gb_quantity_value(&quantities->of[j]);
    }
    study->events[point] = study->events_taken + study->record.n_events;
    return code;
}

static int run_point(gb_sim *sim, gb_study *study, double slice) {
    const double *times = study->times + (size_t)study->point * (size_t)study->n_times;
    const double t_end = times[study->n_times - 1];
    int code = study->begun ? GB_DONE : begin(sim, study), full = 1;
    while (code == GB_DONE && full) {
        code = gb_run(sim, times, study->n_times, t_end, &study->record, slice);
        full = code == GB_FULL && study->record.n_rows == study->record.row_capacity;
        if (code == GB_DONE || full) {
            code = evaluate(sim, study);
        }
    }
    return code == GB_DONE ? end(sim, study) : code;
}

int gb_study_run(gb_sim *sim, gb_study *study, double slice) {
    const clock_t begun = clock();
    double left = slice;
    while (study->point < study->n_points) {
        if (left <= 0.0) {
            return GB_PAUSE;
        }
        const int code = run_point(sim, study, left);
        if (code != GB_DONE) {
            return code;
        }
        study->point++;
        study->begun = 0;
        left = slice - (double)(clock() - begun) / CLOCKS_PER_SEC;
    }
    return GB_DONE;
}
