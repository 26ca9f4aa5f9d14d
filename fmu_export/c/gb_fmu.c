#include "gb_fmu_internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- reasons ------------------------------------------------------------------------------------------------- */

int gb_fmu_refuse(gb_fmu *fmu, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(fmu->message, sizeof fmu->message, format, args);
    va_end(args);
    return -1;
}

const char *gb_fmu_phase_words(int phase) {
    static const char *const words[] = {"before the initialization", "in the initialization", "while it runs",
                                        "after its end", "after a failure"};
    return words[phase];
}

static const char *input_name(const gb_fmu *fmu, int index) {
    for (int i = 0; i < fmu->table->count[GB_FMU_INPUT]; i++)
        if (fmu->table->entries[GB_FMU_INPUT][i].index == index)
            return fmu->table->entries[GB_FMU_INPUT][i].name;
    return "?";
}

static const char *state_name(const gb_fmu *fmu, int index) {
    const gb_model *model = gb_model_of(fmu->sim);
    if (index >= 0 && index < model->n)
        return fmu->table->states[index];
    for (int i = 0; i < fmu->table->count[GB_FMU_PARAMETER]; i++)
        if (fmu->table->entries[GB_FMU_PARAMETER][i].index == index - model->n)
            return fmu->table->entries[GB_FMU_PARAMETER][i].name;
    return "?";
}

static const char *switch_name(const gb_fmu *fmu, int index) {
    const int n = gb_model_of(fmu->sim)->n_switches;
    if (index >= 0 && index < n)
        return fmu->table->switches[index];
    return index >= n ? input_name(fmu, index - n) : "?";
}

/* The solver gave up: name what, when, why. */
int gb_fmu_solver_failed(gb_fmu *fmu, int code) {
    gb_report report;
    gb_get_report(fmu->sim, &report);
    fmu->s.phase = GB_FMU_FAILED;
    fmu->fresh = 0;
    const double t = report.t;
    switch (code) {
    case GB_ERR_STEP:
        return gb_fmu_refuse(fmu, "step size fell below rounding at t = %.9g s; the largest error is in '%s'", t,
                             state_name(fmu, report.index));
    case GB_ERR_NAN_RATE:
        return gb_fmu_refuse(fmu, "the derivative of '%s' is %g at t = %.9g s", state_name(fmu, report.index),
                             report.value, t);
    case GB_ERR_NAN_INPUT:
        return gb_fmu_refuse(fmu, "input '%s' is %g at t = %.9g s", input_name(fmu, report.index), report.value, t);
    case GB_ERR_NAN_START:
        return gb_fmu_refuse(fmu, "start value '%s' is %g", state_name(fmu, report.index), report.value);
    case GB_ERR_CHATTER:
        return gb_fmu_refuse(fmu, "'%s' switches without progress of time at t = %.9g s",
                             switch_name(fmu, report.index), t);
    case GB_ERR_BRANCH:
        return gb_fmu_refuse(fmu, "no consistent mode of '%s' after an event at t = %.9g s",
                             switch_name(fmu, report.index), t);
    case GB_ERR_SINGULAR:
        return gb_fmu_refuse(fmu, "the matrix of a step has no inverse at t = %.9g s, in '%s'", t,
                             state_name(fmu, report.index));
    case GB_ERR_UNSTABLE:
        return gb_fmu_refuse(fmu,
                             "the fixed step of %.9g s is outside the stability of the method at t = %.9g s; the"
                             " largest error is in '%s'",
                             report.value, t, state_name(fmu, report.index));
    case GB_ERR_ESCAPE:
        return gb_fmu_refuse(fmu, "the motion grows without bound at t = %.9g s, quickest in '%s'", t,
                             state_name(fmu, report.index));
    case GB_ERR_MEMORY:
        return gb_fmu_refuse(fmu, "out of memory at t = %.9g s", t);
    default:
        return gb_fmu_refuse(fmu, "the solver stopped with code %d at t = %.9g s", code, t);
    }
}

/* ---- open, close, reset -------------------------------------------------------------------------------------- */

static void set_start_values(gb_fmu *fmu) {
    const gb_fmu_table *table = fmu->table;
    double *targets[GB_FMU_KINDS] = {NULL, gb_parameters(fmu->sim), gb_inputs(fmu->sim), NULL, fmu->start};
    for (int kind = 0; kind < GB_FMU_KINDS; kind++)
        for (int i = 0; targets[kind] && i < table->count[kind]; i++)
            targets[kind][table->entries[kind][i].index] = table->entries[kind][i].start;
    gb_changed(fmu->sim);

    memset(&fmu->s, 0, sizeof fmu->s);
    memcpy(fmu->s.token, table->token, GB_FMU_TOKEN);
    fmu->s.options.method = table->method;
    fmu->s.options.locate = table->locate;
    fmu->s.options.rtol = 1e-6;
    fmu->s.options.max_step = table->max_step;
    fmu->s.options.t_stop = HUGE_VAL;
    for (int i = 0; i < table->count[GB_FMU_SOLVER]; i++) {
        const gb_fmu_entry *entry = &table->entries[GB_FMU_SOLVER][i];
        if (entry->index == GB_FMU_RTOL)
            fmu->s.options.rtol = entry->start;
        if (entry->index == GB_FMU_STEP)
            fmu->s.options.step = entry->start;
    }
    fmu->s.phase = GB_FMU_NEW;
    fmu->fresh = 0;
}

gb_fmu *gb_fmu_open(void) {
    const gb_model *model = gb_get_model();
    gb_fmu *fmu = calloc(1, sizeof *fmu);
    if (!fmu)
        return NULL;
    fmu->table = &gb_fmu_the_table;
    fmu->sim = gb_open(model);
    fmu->outputs = calloc((size_t)model->n_outputs + 1, sizeof *fmu->outputs);
    fmu->start = calloc((size_t)model->n_total + 1, sizeof *fmu->start);
    if (!fmu->sim || !fmu->outputs || !fmu->start) {
        gb_fmu_close(fmu);
        return NULL;
    }
    set_start_values(fmu);
    return fmu;
}

void gb_fmu_close(gb_fmu *fmu) {
    if (!fmu)
        return;
    if (fmu->sim)
        gb_close(fmu->sim);
    free(fmu->outputs);
    free(fmu->start);
    free(fmu);
}

int gb_fmu_reset(gb_fmu *fmu) {
    gb_sim *sim = gb_open(gb_get_model());
    if (!sim)
        return gb_fmu_refuse(fmu, "out of memory in the reset");
    gb_close(fmu->sim);
    fmu->sim = sim;
    set_start_values(fmu);
    return 0;
}

const char *gb_fmu_message(const gb_fmu *fmu) {
    return fmu->message;
}

double gb_fmu_time(const gb_fmu *fmu) {
    return fmu->s.t;
}

long long gb_fmu_events(const gb_fmu *fmu) {
    gb_stats stats;
    gb_get_stats(fmu->sim, &stats);
    return stats.events;
}

/* ---- life cycle ---------------------------------------------------------------------------------------------- */

int gb_fmu_setup(gb_fmu *fmu, double start, const double *stop, const double *rtol) {
    if (fmu->s.phase != GB_FMU_NEW)
        return gb_fmu_refuse(fmu, "an experiment is set up before the initialization, not %s",
                             gb_fmu_phase_words(fmu->s.phase));
    if (!isfinite(start))
        return gb_fmu_refuse(fmu, "the start time is %g; it must be finite", start);
    if (stop && !(*stop > start))
        return gb_fmu_refuse(fmu, "the stop time %.9g s must be later than the start time %.9g s", *stop, start);
    if (rtol && !(*rtol >= 1e-14 && *rtol <= 0.1))
        return gb_fmu_refuse(fmu, "the tolerance is %g; it must lie in [1e-14, 0.1]", *rtol);
    fmu->s.t_start = fmu->s.t = start;
    fmu->s.options.t_stop = stop ? *stop : HUGE_VAL;
    if (rtol)
        fmu->s.options.rtol = *rtol;
    return 0;
}

int gb_fmu_initialize(gb_fmu *fmu) {
    if (fmu->s.phase != GB_FMU_NEW)
        return gb_fmu_refuse(fmu, "the initialization is entered once after instantiation or reset, not %s",
                             gb_fmu_phase_words(fmu->s.phase));
    fmu->s.phase = GB_FMU_INITIALIZING;
    return 0;
}

int gb_fmu_start(gb_fmu *fmu) {
    if (fmu->s.started)
        return 0;
    const double *y0 = fmu->table->count[GB_FMU_START] ? fmu->start : NULL;
    const int code = gb_start(fmu->sim, &fmu->s.options, fmu->s.t_start, y0);
    if (code < 0) {
        const int phase = fmu->s.phase;
        gb_fmu_solver_failed(fmu, code);
        fmu->s.phase = phase; /* nothing has run yet: other start values may do */
        return -1;
    }
    fmu->s.started = 1;
    fmu->fresh = 0;
    return 0;
}

int gb_fmu_begin(gb_fmu *fmu) {
    if (fmu->s.phase != GB_FMU_INITIALIZING)
        return gb_fmu_refuse(fmu, "the initialization cannot end %s", gb_fmu_phase_words(fmu->s.phase));
    if (gb_fmu_start(fmu))
        return -1;
    fmu->s.phase = GB_FMU_RUNNING;
    return 0;
}

int gb_fmu_step(gb_fmu *fmu, double t, double h) {
    const double slack = 1e-12 * fabs(t) + 1e-6 * fabs(h);
    if (fmu->s.phase != GB_FMU_RUNNING)
        return gb_fmu_refuse(fmu, "a step is asked %s", gb_fmu_phase_words(fmu->s.phase));
    if (!isfinite(t) || !isfinite(h) || !(h > 0.0))
        return gb_fmu_refuse(fmu, "a step of %g s from t = %g s is asked at t = %.9g s; it must be positive and finite",
                             h, t, fmu->s.t);
    if (!(fabs(t - fmu->s.t) <= slack))
        return gb_fmu_refuse(fmu, "a step from t = %.9g s is asked but the instance stands at t = %.9g s", t, fmu->s.t);
    double end = t + h;
    if (end > fmu->s.options.t_stop + slack)
        return gb_fmu_refuse(fmu, "a step to t = %.9g s is asked beyond the stop time %.9g s", end,
                             fmu->s.options.t_stop);
    if (!(end > fmu->s.t))
        return gb_fmu_refuse(fmu, "a step of %g s vanishes in the rounding of t = %.9g s", h, fmu->s.t);
    if (end > fmu->s.options.t_stop)
        end = fmu->s.options.t_stop;
    fmu->fresh = 0;
    const int code = gb_advance(fmu->sim, end);
    if (code < 0)
        return gb_fmu_solver_failed(fmu, code);
    fmu->s.t = end;
    return 0;
}

int gb_fmu_end(gb_fmu *fmu) {
    if (fmu->s.phase != GB_FMU_RUNNING && fmu->s.phase != GB_FMU_FAILED)
        return gb_fmu_refuse(fmu, "the run cannot end %s", gb_fmu_phase_words(fmu->s.phase));
    fmu->s.phase = GB_FMU_ENDED;
    return 0;
}
