/* Checks of the solver core against trains written by hand. No timing. Exit status 0: all passed. */
#include "checks.h"

int failures = 0;

gb_options options_of(int method, double rtol, double step) {
    const gb_options options = {method, 1, rtol, step, HUGE_VAL, HUGE_VAL};
    return options;
}

gb_sim *open_model(const gb_model *model, const double *values, const gb_options *options, int *code) {
    gb_sim *sim = gb_open(model);
    memcpy(gb_parameters(sim), values, sizeof(double) * (size_t)model->n_parameters);
    *code = gb_start(sim, options, 0.0, NULL);
    return sim;
}

size_t row_length(const gb_model *m) {
    return (size_t)(1 + m->n_total + m->n_switches + m->n_inputs);
}

static run make_run(const gb_model *model, const double *values, gb_options options, long rows) {
    run r;
    r.sim = open_model(model, values, &options, &r.code);
    r.record.rows = malloc(sizeof(double) * (size_t)rows * row_length(model));
    r.record.events = malloc(sizeof(gb_event) * MAX_EVENTS);
    r.record.n_rows = r.record.n_events = 0;
    r.record.quantities = NULL;
    r.record.watches = NULL;
    r.record.row_capacity = rows;
    r.record.event_capacity = MAX_EVENTS;
    return r;
}

run run_samples(const gb_model *model, const double *values, gb_options options, const double *t, long n) {
    run r = make_run(model, values, options, n);
    if (r.code == GB_DONE) {
        r.code = gb_run(r.sim, t, n, t[n - 1], &r.record, 0.0);
    }
    return r;
}

run run_steps(const gb_model *model, const double *values, gb_options options, double t_end, long capacity) {
    run r = make_run(model, values, options, capacity);
    if (r.code == GB_DONE) {
        r.code = gb_run(r.sim, NULL, 0, t_end, &r.record, 0.0);
    }
    return r;
}

void free_run(run *r) {
    free(r->record.rows);
    free(r->record.events);
    gb_close(r->sim);
}

void grid(double *t, long n, double t_end) {
    for (long i = 0; i < n; i++) {
        t[i] = t_end * (double)i / (double)(n - 1);
    }
}

/* Largest difference of a state over the rows, relative to its largest value. */
double largest_error(const run *r, const run *reference, int state) {
    const size_t length = row_length(gb_model_of(r->sim));
    double error = 0.0, size = 0.0;
    for (long i = 0; i < r->record.n_rows; i++) {
        const size_t at = (size_t)i * length + 1 + (size_t)state;
        error = fmax(error, fabs(r->record.rows[at] - reference->record.rows[at]));
        size = fmax(size, fabs(reference->record.rows[at]));
    }
    return error / size;
}

int main(void) {
    check_math();
    check_accuracy();
    check_events();
    check_inputs();
    check_state();
    check_hard();
    check_stiff();
    check_tangents();
    if (failures)
        printf("%d checks do not hold\n", failures);
    else
        printf("all checks hold\n");
    return failures != 0;
}
