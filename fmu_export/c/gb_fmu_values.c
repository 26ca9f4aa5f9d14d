/* Variables by reference, and saved states. */
#include "gb_fmu_internal.h"

#include <math.h>
#include <string.h>

/* ---- variables ----------------------------------------------------------------------------------------------- */

static const gb_fmu_entry *find(gb_fmu *fmu, unsigned ref, int *kind) {
    const unsigned position = ref & ((1u << GB_FMU_KIND_SHIFT) - 1u);
    const unsigned k = ref >> GB_FMU_KIND_SHIFT;
    if (k >= GB_FMU_KINDS || position >= (unsigned)fmu->table->count[k]) {
        gb_fmu_refuse(fmu, "no real variable has the value reference %u", ref);
        return NULL;
    }
    *kind = (int)k;
    return &fmu->table->entries[k][position];
}

static double *place(gb_fmu *fmu, int kind, const gb_fmu_entry *entry) {
    switch (kind) {
    case GB_FMU_PARAMETER:
        return &fmu->solver->parameters(fmu->sim)[entry->index];
    case GB_FMU_INPUT:
        return &fmu->solver->inputs(fmu->sim)[entry->index];
    case GB_FMU_START:
        return &fmu->start[entry->index];
    case GB_FMU_OUTPUT:
        return &fmu->outputs[entry->index];
    default:
        if (entry->index == GB_FMU_TIME)
            return &fmu->s.t;
        return entry->index == GB_FMU_RTOL ? &fmu->s.options.rtol : &fmu->s.options.step;
    }
}

static int refresh_outputs(gb_fmu *fmu, const gb_fmu_entry *entry) {
    if (fmu->fresh)
        return 0;
    if (fmu->s.phase == GB_FMU_NEW)
        return gb_fmu_refuse(fmu, "output '%s' has no value %s", entry->name, gb_fmu_phase_words(fmu->s.phase));
    if (fmu->s.phase == GB_FMU_INITIALIZING && gb_fmu_start(fmu))
        return -1;
    if (!fmu->s.started)
        return gb_fmu_refuse(fmu, "output '%s' has no value %s", entry->name, gb_fmu_phase_words(fmu->s.phase));
    const int code = fmu->solver->outputs(fmu->sim, fmu->outputs);
    if (code < 0)
        return gb_fmu_solver_failed(fmu, code);
    fmu->fresh = 1;
    return 0;
}

int gb_fmu_get(gb_fmu *fmu, const unsigned *refs, size_t n, double *values) {
    for (size_t i = 0; i < n; i++) {
        int kind = 0;
        const gb_fmu_entry *entry = find(fmu, refs[i], &kind);
        if (!entry || (kind == GB_FMU_OUTPUT && refresh_outputs(fmu, entry)))
            return -1;
        values[i] = *place(fmu, kind, entry);
        if (!isfinite(values[i]))
            return gb_fmu_refuse(fmu, "'%s' is %g at t = %.9g s", entry->name, values[i], fmu->s.t);
    }
    return 0;
}

static int may_set(gb_fmu *fmu, int kind, const gb_fmu_entry *entry, double value) {
    const int phase = fmu->s.phase;
    const double t = fmu->s.t;
    if (kind == GB_FMU_OUTPUT || (kind == GB_FMU_SOLVER && entry->index == GB_FMU_TIME))
        return gb_fmu_refuse(fmu, "'%s' cannot be set at t = %.9g s: it is computed", entry->name, t);
    if (phase == GB_FMU_ENDED || phase == GB_FMU_FAILED)
        return gb_fmu_refuse(fmu, "'%s' cannot be set %s, at t = %.9g s", entry->name, gb_fmu_phase_words(phase), t);
    if (phase == GB_FMU_RUNNING && !entry->tunable)
        return gb_fmu_refuse(fmu, "'%s' is fixed since the start of the run, and is set at t = %.9g s", entry->name, t);
    if (!isfinite(value))
        return gb_fmu_refuse(fmu, "'%s' is set to %g at t = %.9g s; it must be finite", entry->name, value, t);
    if (value < entry->lower || value > entry->upper || (entry->open_lower && value == entry->lower) ||
        (entry->open_upper && value == entry->upper))
        return gb_fmu_refuse(fmu, "'%s' is set to %.9g at t = %.9g s; it must lie in %c%.9g, %.9g%c", entry->name,
                             value, t, entry->open_lower ? '(' : '[', entry->lower, entry->upper,
                             entry->open_upper ? ')' : ']');
    return 0;
}

int gb_fmu_set(gb_fmu *fmu, const unsigned *refs, size_t n, const double *values) {
    for (size_t i = 0; i < n; i++) {
        int kind = 0;
        const gb_fmu_entry *entry = find(fmu, refs[i], &kind);
        if (!entry || may_set(fmu, kind, entry, values[i]))
            return -1;
    }
    for (size_t i = 0; i < n; i++) {
        int kind = 0;
        const gb_fmu_entry *entry = find(fmu, refs[i], &kind);
        double *target = place(fmu, kind, entry);
        if (kind == GB_FMU_SOLVER && entry->index == GB_FMU_RTOL)
            fmu->s.own_rtol = 1;
        if (*target == values[i])
            continue;
        *target = values[i];
        fmu->fresh = 0;
        if (fmu->s.phase == GB_FMU_RUNNING)
            fmu->solver->changed(fmu->sim);
        else
            fmu->s.started = 0;
    }
    return 0;
}

/* ---- saved states -------------------------------------------------------------------------------------------- */

static size_t start_size(const gb_fmu *fmu) {
    return (size_t)fmu->solver->model_of(fmu->sim)->n_total * sizeof(double);
}

size_t gb_fmu_block_size(const gb_fmu *fmu) {
    return sizeof(gb_fmu_state) + start_size(fmu) + fmu->solver->snapshot_size(fmu->sim);
}

/* Of the part in front of the solver's block (which has a checksum of its own), the place of the sum left out. */
static unsigned long long checksum_of(const gb_fmu *fmu, const char *block) {
    const size_t at = offsetof(gb_fmu_state, checksum), after = at + sizeof(unsigned long long);
    return fmu->solver->checksum(block + after, sizeof(gb_fmu_state) + start_size(fmu) - after,
                                 fmu->solver->checksum(block, at, 0));
}

void gb_fmu_save(const gb_fmu *fmu, void *block) {
    char *bytes = block;
    memcpy(bytes, &fmu->s, sizeof fmu->s);
    memcpy(bytes + sizeof fmu->s, fmu->start, start_size(fmu));
    fmu->solver->save(fmu->sim, bytes + sizeof fmu->s + start_size(fmu));
    const unsigned long long checksum = checksum_of(fmu, bytes);
    memcpy(bytes + offsetof(gb_fmu_state, checksum), &checksum, sizeof checksum);
}

static int in_range(const gb_fmu_state *state) {
    return state->phase >= GB_FMU_NEW && state->phase <= GB_FMU_FAILED &&
           (state->started == 0 || state->started == 1) && (state->own_rtol == 0 || state->own_rtol == 1) &&
           isfinite(state->t) && isfinite(state->t_asked) && isfinite(state->t_start) &&
           state->options.rtol >= GB_FMU_LEAST_RTOL && state->options.rtol <= GB_FMU_MOST_RTOL;
}

int gb_fmu_fits(gb_fmu *fmu, const void *block, size_t size) {
    const char *bytes = block;
    gb_fmu_state state;
    if (size != gb_fmu_block_size(fmu))
        return gb_fmu_refuse(fmu, "a saved state of %zu bytes is given; this model's has %zu", size,
                             gb_fmu_block_size(fmu));
    if (memcmp(block, fmu->table->token, GB_FMU_TOKEN) != 0)
        return gb_fmu_refuse(fmu, "the saved state belongs to another model");
    memcpy(&state, bytes, sizeof state);
    if (state.checksum != checksum_of(fmu, bytes) || !in_range(&state) ||
        !fmu->solver->fits(fmu->sim, bytes + sizeof state + start_size(fmu)))
        return gb_fmu_refuse(fmu, "the saved state is damaged");
    return 0;
}

int gb_fmu_restore(gb_fmu *fmu, const void *block) {
    const char *bytes = block;
    if (gb_fmu_fits(fmu, block, gb_fmu_block_size(fmu)))
        return -1;
    if (fmu->solver->restore(fmu->sim, bytes + sizeof fmu->s + start_size(fmu)) < 0)
        return gb_fmu_refuse(fmu, "the saved state is damaged");
    memcpy(&fmu->s, bytes, sizeof fmu->s);
    memcpy(fmu->start, bytes + sizeof fmu->s, start_size(fmu));
    fmu->fresh = 0;
    return 0;
}
