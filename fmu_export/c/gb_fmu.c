#include "gb_fmu_internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_BETWEEN_LOOKS = 8, MOST_BETWEEN_LOOKS = 256 }; /* at the clock: steps and events */

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

/* ---- open, close, reset -------------------------------------------------------------------------------------- */

static void set_start_values(gb_fmu *fmu) {
    const gb_fmu_table *table = fmu->table;
    double *targets[GB_FMU_KINDS] = {NULL, fmu->solver->parameters(fmu->sim), fmu->solver->inputs(fmu->sim), NULL,
                                     fmu->start};
    for (int kind = 0; kind < GB_FMU_KINDS; kind++)
        for (int i = 0; targets[kind] && i < table->count[kind]; i++)
            targets[kind][table->entries[kind][i].index] = table->entries[kind][i].start;
    fmu->solver->changed(fmu->sim);

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

const char *gb_fmu_missing(void) {
    return gb_solver_here() ? NULL : gb_solver_words();
}

gb_fmu *gb_fmu_open(void) {
    gb_fmu *fmu = gb_solver_here() ? calloc(1, sizeof *fmu) : NULL;
    if (!fmu)
        return NULL;
    fmu->solver = gb_solver_here();
    const gb_model *model = fmu->solver->get_model();
    fmu->table = &gb_fmu_the_table;
    fmu->sim = fmu->solver->open(model);
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
        fmu->solver->close(fmu->sim);
    free(fmu->outputs);
    free(fmu->start);
    free(fmu);
}

int gb_fmu_reset(gb_fmu *fmu) {
    gb_sim *sim = fmu->solver->open(fmu->solver->get_model());
    if (!sim)
        return gb_fmu_refuse(fmu, "out of memory in the reset");
    fmu->solver->close(fmu->sim);
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
    fmu->solver->get_stats(fmu->sim, &stats);
    return stats.events;
}

/* ---- life cycle ---------------------------------------------------------------------------------------------- */

/* The importer's tolerance; a wish that a tolerance set as a variable overrules. */
static int take_tolerance(gb_fmu *fmu, double rtol) {
    double *own = &fmu->s.options.rtol;
    if (fmu->s.own_rtol)
        return 0;
    if (rtol >= GB_FMU_LEAST_RTOL && rtol <= GB_FMU_MOST_RTOL) {
        *own = rtol;
        return 0;
    }
    if (rtol > 0.0)
        *own = rtol > GB_FMU_MOST_RTOL ? GB_FMU_MOST_RTOL : GB_FMU_LEAST_RTOL;
    gb_fmu_refuse(fmu, "the tolerance %g does not lie in [%g, %g]; %g is taken", rtol, GB_FMU_LEAST_RTOL,
                  GB_FMU_MOST_RTOL, *own);
    return 1;
}

int gb_fmu_setup(gb_fmu *fmu, double start, const double *stop, const double *rtol) {
    if (fmu->s.phase != GB_FMU_NEW)
        return gb_fmu_refuse(fmu, "an experiment is set up before the initialization, not %s",
                             gb_fmu_phase_words(fmu->s.phase));
    if (!isfinite(start))
        return gb_fmu_refuse(fmu, "the start time is %g; it must be finite", start);
    if (stop && !(*stop > start))
        return gb_fmu_refuse(fmu, "the stop time %.9g s must be later than the start time %.9g s", *stop, start);
    if (rtol && (!isfinite(*rtol) || *rtol < 0.0))
        return gb_fmu_refuse(fmu, "the tolerance is %g; it must be a number >= 0", *rtol);
    fmu->s.t_start = fmu->s.t = fmu->s.t_asked = start;
    fmu->s.options.t_stop = stop ? *stop : HUGE_VAL;
    return rtol ? take_tolerance(fmu, *rtol) : 0;
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
    const int code = fmu->solver->start(fmu->sim, &fmu->s.options, fmu->s.t_start, y0);
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

/* To t, or as far as the patience of the table goes. The clock is read between runs of steps alone, which become longer
 * while they take next to none of it: most calls end within the first. They are short again in the next call, whose
 * steps may be dear ones. Where a run takes long, so may each of its steps, and the clock is read after every one. */
static int advance(gb_fmu *fmu, double t) {
    const double patience = fmu->table->patience;
    long moves = FIRST_BETWEEN_LOOKS;
    int code = fmu->solver->advance_within(fmu->sim, t, moves);
    if (code != GB_PAUSE)
        return code;
    double now = gb_fmu_clock();
    for (const double until = now + patience; code == GB_PAUSE && now < until;) {
        const double before = now;
        code = fmu->solver->advance_within(fmu->sim, t, moves);
        now = gb_fmu_clock();
        if (now - before < 0.01 * patience)
            moves = moves < MOST_BETWEEN_LOOKS ? 2 * moves : MOST_BETWEEN_LOOKS;
        else if (now - before > 0.1 * patience)
            moves = 1;
    }
    return code;
}

/* Whether a step from t may be asked: from where the instance stands, or again from where the last one was asked. */
static int stands_at(const gb_fmu *fmu, double t, double slack) {
    return fabs(t - fmu->s.t) <= slack || (fmu->s.t_asked < fmu->s.t && fabs(t - fmu->s.t_asked) <= slack);
}

int gb_fmu_step(gb_fmu *fmu, double t, double h) {
    const double slack = 1e-12 * fabs(t) + 1e-6 * fabs(h);
    if (fmu->s.phase != GB_FMU_RUNNING)
        return gb_fmu_refuse(fmu, "a step is asked %s", gb_fmu_phase_words(fmu->s.phase));
    if (!isfinite(t) || !isfinite(h) || !(h > 0.0) || !isfinite(t + h))
        return gb_fmu_refuse(fmu, "a step of %g s from t = %g s is asked at t = %.9g s; it must be positive and finite",
                             h, t, fmu->s.t);
    if (!stands_at(fmu, t, slack))
        return gb_fmu_refuse(fmu, "a step from t = %.9g s is asked but the instance stands at t = %.9g s", t, fmu->s.t);
    double end = t + h;
    if (end > fmu->s.options.t_stop + slack)
        return gb_fmu_refuse(fmu, "a step to t = %.9g s is asked beyond the stop time %.9g s", end,
                             fmu->s.options.t_stop);
    if (!(end > fmu->s.t))
        return gb_fmu_refuse(
            fmu, "a step of %g s from t = %.9g s does not lead beyond t = %.9g s, where the instance stands", h, t,
            fmu->s.t);
    if (end > fmu->s.options.t_stop)
        end = fmu->s.options.t_stop;
    fmu->fresh = 0;
    const int code = advance(fmu, end);
    if (code < 0)
        return gb_fmu_solver_failed(fmu, code);
    fmu->s.t_asked = code == GB_PAUSE ? t : end;
    fmu->s.t = code == GB_PAUSE ? fmu->solver->time(fmu->sim) : end;
    if (code == GB_DONE)
        return 0;
    gb_fmu_refuse(fmu,
                  "%.9g s of the step to t = %.9g s take more than %g s of processor time; the instance stands at t = "
                  "%.9g s and goes on from there, or where the step is asked for again",
                  h, end, fmu->table->patience, fmu->s.t);
    return 1;
}

int gb_fmu_end(gb_fmu *fmu) {
    if (fmu->s.phase != GB_FMU_RUNNING && fmu->s.phase != GB_FMU_FAILED)
        return gb_fmu_refuse(fmu, "the run cannot end %s", gb_fmu_phase_words(fmu->s.phase));
    fmu->s.phase = GB_FMU_ENDED;
    return 0;
}
