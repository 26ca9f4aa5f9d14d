/* Why the solver gave up, in words: what, when, why. */
#include "gb_fmu_internal.h"

static const char *name_among(const gb_fmu *fmu, int kind, int index) {
    for (int i = 0; i < fmu->table->count[kind]; i++)
        if (fmu->table->entries[kind][i].index == index)
            return fmu->table->entries[kind][i].name;
    return "?";
}

/* Of an entry of the state vector; behind the n states, where it is one of the unknowns of a step, of a massless speed.
 */
static const char *state_name(const gb_fmu *fmu, int index, int unknown) {
    const gb_fmu_table *table = fmu->table;
    if (index >= 0 && index < (unknown ? table->n_states : fmu->solver->model_of(fmu->sim)->n))
        return table->states[index];
    for (int i = 0; i < table->n_quadratures; i++)
        if (!unknown && table->quadratures[i].index == index)
            return table->quadratures[i].name;
    return "?";
}

static const char *start_name(const gb_fmu *fmu, int index) {
    const int n = fmu->solver->model_of(fmu->sim)->n;
    return index < n ? state_name(fmu, index, 0) : name_among(fmu, GB_FMU_PARAMETER, index - n);
}

static const char *switch_name(const gb_fmu *fmu, int index) {
    const int n = fmu->table->n_switches;
    if (index >= n)
        return name_among(fmu, GB_FMU_INPUT, index - n);
    return index >= 0 ? fmu->table->switches[index] : "?";
}

static const char *state_or_switch_name(const gb_fmu *fmu, int index) {
    const int n = fmu->solver->model_of(fmu->sim)->n;
    return index < n ? state_name(fmu, index, 0) : switch_name(fmu, index - n);
}

int gb_fmu_solver_failed(gb_fmu *fmu, int code) {
    gb_report report;
    fmu->solver->get_report(fmu->sim, &report);
    fmu->s.phase = GB_FMU_FAILED;
    fmu->fresh = 0;
    const double t = report.t;
    const int i = report.index;
    switch (code) {
    case GB_ERR_STEP:
        return gb_fmu_refuse(fmu, "step size fell below rounding at t = %.9g s; the largest error is in '%s'", t,
                             state_name(fmu, i, 0));
    case GB_ERR_NAN_RATE:
        return gb_fmu_refuse(fmu, "the derivative of '%s' is %g at t = %.9g s", state_name(fmu, i, 0), report.value, t);
    case GB_ERR_NAN_INPUT:
        return gb_fmu_refuse(fmu, "input '%s' is %g at t = %.9g s", name_among(fmu, GB_FMU_INPUT, i), report.value, t);
    case GB_ERR_NAN_START:
        return gb_fmu_refuse(fmu, "start value '%s' is %g", start_name(fmu, i), report.value);
    case GB_ERR_CHATTER:
        return gb_fmu_refuse(fmu, "'%s' switches without progress of time at t = %.9g s", switch_name(fmu, i), t);
    case GB_ERR_BRANCH:
        return gb_fmu_refuse(fmu, "no consistent mode of '%s' after an event at t = %.9g s", switch_name(fmu, i), t);
    case GB_ERR_LOSS:
        return gb_fmu_refuse(fmu, "no motion, or more than one, agrees with the losses of '%s' at t = %.9g s",
                             switch_name(fmu, i), t);
    case GB_ERR_BEYOND:
        return gb_fmu_refuse(fmu, "the start values contradict '%s' at t = %.9g s", switch_name(fmu, i), t);
    case GB_ERR_SINGULAR:
        return gb_fmu_refuse(fmu, "the matrix of a step has no inverse at t = %.9g s, in '%s'", t,
                             state_name(fmu, i, 1));
    case GB_ERR_UNSTABLE:
        return gb_fmu_refuse(
            fmu,
            "the fixed step of %.9g s is outside the stability of the method at t = %.9g s; the largest"
            " error is in '%s'",
            report.value, t, state_name(fmu, i, 0));
    case GB_ERR_ESCAPE:
        return gb_fmu_refuse(fmu, "the motion grows without bound at t = %.9g s, quickest in '%s'", t,
                             state_name(fmu, i, 0));
    case GB_ERR_JUMP:
        return gb_fmu_refuse(fmu, "friction on a shaft without inertia and damping jumps at t = %.9g s, at '%s'", t,
                             state_name(fmu, i, 0));
    case GB_ERR_STALL:
        return gb_fmu_refuse(fmu, "%.0f steps or tries in a row hardly bring the run on at t = %.9g s, in '%s'",
                             report.value, t, state_or_switch_name(fmu, i));
    case GB_ERR_MEMORY:
        return gb_fmu_refuse(fmu, "out of memory at t = %.9g s", t);
    default:
        return gb_fmu_refuse(fmu, "the solver stopped with code %d at t = %.9g s", code, t);
    }
}
