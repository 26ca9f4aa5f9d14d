#include "gb_memory.h"
#include "gb_active_set.h"
#include "gb_enclosure.h"
#include "gb_methods.h"
#include "gb_sparse_ldu.h"

#include <stdlib.h>

enum { LINE = 64 };
enum { MOST_RESPONSES = 4096 }; /* of constraint forces to torques: beyond, samples cost less */

void gb_set_method(gb_sim *sim, int method) {
    sim->head->method = method;
    sim->method = &gb_method_table[method];
}

/* The next `bytes` at cache line boundaries; a null base only counts. */
static void *take(char *base, size_t *at, size_t bytes) {
    const size_t here = *at;
    *at += (bytes + LINE - 1) / LINE * LINE;
    return base ? base + here : NULL;
}

static double *doubles(char *base, size_t *at, long count) {
    return take(base, at, sizeof(double) * (size_t)(count > 0 ? count : 1));
}

/* What changes during a run. Returns its size. */
static size_t lay_block(gb_sim *sim, char *base) {
    const gb_model *m = sim->model;
    struct gb_events *events = &sim->events;
    struct gb_control *control = &sim->control;
    size_t at = 0;
    sim->head = take(base, &at, sizeof(gb_head));
    double **const by_input[] = {&sim->inputs.value, &sim->inputs.cell, &sim->inputs.cell_end};
    double **const by_switch[] = {&events->lo,        &events->hi,          &events->armed,     &events->pending,
                                  &events->next_mode, &events->next_time,   &events->flip_time, &events->flips,
                                  &events->held,      &events->held_side,   &events->shortest,  &events->shortest_at,
                                  &events->swings,    &events->swings_from, &events->stayed};
    double **const by_state[] = {&control->largest,      &control->natural_scale, &control->noise,
                                 &control->error_weight, &control->least_scale,   &control->fastest_rate,
                                 &control->fast};
    double **const whole[] = {&sim->y0, &sim->y, &sim->k1};
    sim->par = doubles(base, &at, m->n_par > m->n_parameters ? m->n_par : m->n_parameters);
    for (size_t i = 0; i < sizeof by_input / sizeof by_input[0]; i++) {
        *by_input[i] = doubles(base, &at, m->n_inputs);
    }
    sim->constraints.row_size = doubles(base, &at, m->n_constraints);
    sim->constraints.impacts = doubles(base, &at, m->n_constraints);
    sim->constraints.impact_speed = doubles(base, &at, 2 * m->n_constraints);
    for (size_t i = 0; i < sizeof by_switch / sizeof by_switch[0]; i++) {
        *by_switch[i] = doubles(base, &at, m->n_switches);
    }
    for (size_t i = 0; i < sizeof by_state / sizeof by_state[0]; i++) {
        *by_state[i] = doubles(base, &at, m->n_padded);
    }
    for (size_t i = 0; i < sizeof whole / sizeof whole[0]; i++) {
        *whole[i] = doubles(base, &at, m->n_total);
    }
    sim->rows = doubles(base, &at, (long)GB_ROWS * m->n_total);
    const int modes = m->n_switches + m->n_active_set;
    sim->mode = take(base, &at, 0); /* what follows from the active set lies behind it, and is not saved */
    return at + sizeof(double) * (size_t)(modes > 0 ? modes : 1);
}

/* Doubles behind the modes: the active set and what follows from it. `carried`: without what is made anew at each use.
 */
static long active_set_size(const gb_model *m, long *carried) {
    gb_active_set active;
    double none = 0.0;
    *carried = 0;
    return m->n_constraints > 0 ? gb_active_lay(m->constraint_rows, &none, &active, carried) : 0;
}

size_t gb_modes_size(const gb_model *model) {
    long carried;
    return (size_t)(model->n_switches + active_set_size(model, &carried));
}

/* What events need to decide about switched constraints. */
static void lay_constraints(gb_sim *sim, char *base, size_t *at) {
    const gb_model *m = sim->model;
    const long n = m->n_constraints;
    struct gb_constraints *c = &sim->constraints;
    struct gb_lossy *lossy = &sim->lossy;
    double **const by_constraint[] = {&c->slip,        &c->slip_rounding, &c->right,       &c->lo,
                                      &c->hi,          &c->lo_slope,      &c->hi_slope,    &c->force,
                                      &c->other,       &c->force_before,  &c->slip_before, &c->free_acceleration,
                                      &c->mode_before, &c->shrink,        &c->peak,        &lossy->base_mode};
    double **const by_pair[] = {&sim->implicit.row_inverse, &sim->implicit.row_room};
    int **const marks[] = {
        &c->in,         &c->decision, &c->was_redundant,     &c->released,    &c->struck,       &c->broken,
        &c->was_broken, &c->on,       &lossy->base_decision, &lossy->forward, &lossy->backward, &lossy->option};
    for (size_t i = 0; i < sizeof by_constraint / sizeof by_constraint[0]; i++) {
        *by_constraint[i] = doubles(base, at, n);
    }
    for (size_t i = 0; i < sizeof by_pair / sizeof by_pair[0]; i++) {
        *by_pair[i] = doubles(base, at, m->pattern ? n * n : 0);
    }
    for (size_t i = 0; i < sizeof marks / sizeof marks[0]; i++) {
        *marks[i] = take(base, at, sizeof(int) * (size_t)(n + 1));
    }
    c->bounds = doubles(base, at, 5 * n);
    const long size = n > 0 ? gb_delassus_size(m->n_constraints, m->constraint_rows->pattern) : 0;
    long carried;
    c->delassus = doubles(base, at, size);
    c->room = doubles(base, at, size);
    c->full_mode = doubles(base, at, n > 0 ? m->n_switches + active_set_size(m, &carried) : 0);
    c->row = doubles(base, at, n * m->n_speeds);
    sim->implicit.row_response = doubles(base, at, n > 0 && m->pattern ? n * m->pattern->n : 0);
    sim->implicit.row_change = doubles(base, at, m->constraint_change ? n * m->pattern->n : 0);
    sim->implicit.row_by_state = doubles(base, at, m->constraint_change ? n * (m->n - m->n_speeds + 1) : 0);
}

static void lay_implicit(gb_sim *sim, char *base, size_t *at) {
    const gb_model *m = sim->model;
    struct gb_implicit *s = &sim->implicit;
    double **const by_unknown[] = {&s->diag,    &s->inverse,       &s->work,
                                   &s->unknown, &sim->choice.rate, &sim->choice.inertia};
    for (size_t i = 0; i < sizeof by_unknown / sizeof by_unknown[0]; i++) {
        *by_unknown[i] = doubles(base, at, m->pattern->n);
    }
    s->lower = doubles(base, at, m->pattern->n_places);
    s->upper = doubles(base, at, m->pattern->n_places);
    s->kinematic_terms = doubles(base, at, m->n_kinematic_terms);
    s->n_colours = gb_colour_count(m->pattern);
    const size_t links = (size_t)s->n_colours * (size_t)(m->n_kinematic + 1);
    s->colour = take(base, at, sizeof(int) * (size_t)(m->pattern->n + 1));
    s->link = take(base, at, sizeof(int) * links);
    s->gain = take(base, at, sizeof(double) * links);
    s->tie_place = take(base, at, sizeof(int) * (size_t)(m->pattern->n + 1));
    s->tie_gain = doubles(base, at, m->pattern->n);
    s->cluster = take(base, at, sizeof(int) * (size_t)(m->n_speeds + 1));
    s->cluster_gain = doubles(base, at, m->n_speeds);
}

static void lay_events(gb_sim *sim, char *base, size_t *at) {
    const gb_model *m = sim->model;
    struct gb_events *e = &sim->events;
    double **const by_surface[] = {&e->s0, &e->s, &e->located, &e->side, &e->moved, &e->slack, &e->until};
    for (size_t i = 0; i < sizeof by_surface / sizeof by_surface[0]; i++) {
        *by_surface[i] = doubles(base, at, m->n_switches); /* mode_limits fills those of time too */
    }
    e->slopes = doubles(base, at, (long)GB_ROWS * m->n_affine);
    e->mode_before = doubles(base, at, m->update_states ? m->n_switches : 0);
    e->samples = doubles(base, at, (m->n_event_functions > m->n_affine ? (long)GB_STAGES : 0) * m->n_event_functions);
    long carried;
    sim->unlocated.mode = doubles(base, at, m->n_switches + active_set_size(m, &carried));
    sim->unlocated.n_carried = (size_t)(m->n_switches + carried);
    sim->sliding.mode = doubles(base, at, m->n_switches + active_set_size(m, &carried));
    sim->sliding.rates = doubles(base, at, m->n_event_functions > 0 ? (long)(1 + GB_SLIDING + 2) * m->n_total : 0);
    sim->sliding.functions = doubles(base, at, 2L * m->n_event_functions);
    sim->sliding.outputs = doubles(base, at, m->n_event_functions > 0 ? 2L * m->n_outputs : 0);
    for (int k = 0; k < 3; k++) {
        int **const which[] = {&e->role, &e->slip_of, &e->force_of};
        *which[k] = take(base, at, sizeof(int) * (size_t)(m->n_switches + 1));
    }
    sim->log.capacity = 4L * m->n_switches + m->n_inputs + 64;
    sim->log.event = take(base, at, sizeof(gb_event) * (size_t)sim->log.capacity);
}

static void lay_panel(gb_sim *sim, char *base, size_t *at) {
    const gb_model *m = sim->model;
    struct gb_panel *p = &sim->panel;
    const long read = m->n_arguments_read, n = m->n_arguments > 0 ? m->n_event_functions : 0;
    p->values = doubles(base, at, (long)GB_PANEL_POINTS * m->n_arguments);
    p->bernstein = doubles(base, at, (long)GB_PANEL_POINTS * (read + GB_PAD));
    p->slack = doubles(base, at, read);
    p->misfit = doubles(base, at, read);
    p->rounding = doubles(base, at, read);
    p->left = doubles(base, at, n);
    p->right = doubles(base, at, n);
    p->noise = doubles(base, at, n);
    const long responses = m->force_enclosures ? (long)m->n_groups * m->n_constraints : 0;
    p->unit = doubles(base, at, m->n_groups);
    p->response = doubles(base, at, responses <= MOST_RESPONSES ? responses : 0);
    p->response = responses > 0 && responses <= MOST_RESPONSES ? p->response : NULL;
    p->watched = take(base, at, sizeof(int) * (size_t)(m->n_event_functions + 1));
    p->torque = take(base, at, sizeof(gb_enclosure) * (size_t)(m->n_groups + 1));
    p->bound = take(base, at, sizeof(gb_enclosure) * (size_t)(2 * m->n_constraints + 1));
    p->kept = take(base, at, sizeof(gb_enclosure) * (size_t)(responses > 0 ? m->n_arguments + 1 : 1));
    p->x = take(base, at, sizeof(gb_enclosure) * (size_t)(m->n_arguments + 1));
    p->enclosure = take(base, at, sizeof(gb_enclosure) * (size_t)(n + 1));
}

/* Scratch that may be forgotten between calls. Returns its size. */
static size_t lay_scratch(gb_sim *sim, char *base) {
    const gb_model *m = sim->model;
    size_t at = 0;
    double **const whole[] = {&sim->z, &sim->z2, &sim->zero, &sim->sliding.state};
    gb_lanes *const lanes[] = {&sim->lanes, &sim->instant, &sim->sliding.lanes};
    sim->k = doubles(base, &at, (long)GB_STAGES * m->n_total);
    for (size_t i = 0; i < sizeof whole / sizeof whole[0]; i++) {
        *whole[i] = doubles(base, &at, m->n_total);
    }
    sim->events.defect = doubles(base, &at, 3L * m->n_total);
    sim->scratch.energies = doubles(base, &at, m->n_energies);
    sim->scratch.outputs = doubles(base, &at, m->n_outputs);
    sim->scratch.inputs = doubles(base, &at, m->n_inputs);
    sim->scratch.features = doubles(base, &at, 3L * m->n_features);
    for (size_t i = 0; i < sizeof lanes / sizeof lanes[0]; i++) {
        lanes[i]->t = doubles(base, &at, GB_LANES);
        lanes[i]->u = doubles(base, &at, (long)GB_LANES * m->n_inputs);
        lanes[i]->time_terms = doubles(base, &at, (long)GB_LANES * m->n_time_terms);
    }
    if (m->pattern) {
        lay_implicit(sim, base, &at);
    }
    lay_events(sim, base, &at);
    lay_panel(sim, base, &at);
    lay_constraints(sim, base, &at);
    sim->inputs.source = take(base, &at, sizeof(gb_source) * (size_t)(m->n_inputs + 1));
    sim->inputs.moving = take(base, &at, sizeof(int) * (size_t)(m->n_inputs + 1));
    return at;
}

static uint64_t hash_text(const char *text) {
    uint64_t hash = 1469598103934665603u;
    for (const char *c = text; *c; c++) {
        hash = (hash ^ (unsigned char)*c) * 1099511628211u;
    }
    return hash;
}

gb_sim *gb_open(const gb_model *model) {
    gb_sim *sim = calloc(1, sizeof *sim);
    if (!sim) {
        return NULL;
    }
    sim->model = model;
    sim->method = &gb_method_table[GB_DP8];
    long carried;
    const size_t behind = sizeof(double) * (size_t)active_set_size(model, &carried);
    const size_t block = lay_block(sim, NULL), scratch = lay_scratch(sim, NULL);
    const size_t begin = (block + behind + LINE - 1) / LINE * LINE;
    sim->memory = calloc(1, begin + scratch + LINE);
    if (!sim->memory) {
        free(sim);
        return NULL;
    }
    char *base = sim->memory;
    base += LINE - (uintptr_t)base % LINE;
    sim->block_bytes = lay_block(sim, base);
    lay_scratch(sim, base + begin);
    sim->head->key = hash_text(model->key);
    sim->head->bytes = block;
    for (int i = 0; i < model->n_switches; i++) {
        sim->events.slack[i] = -1.0;
        sim->events.slip_of[i] = sim->events.force_of[i] = -1;
    }
    for (int i = 0; i < model->n_constraints; i++) {
        const gb_constraint *constraint = &model->constraints[i];
        sim->events.role[constraint->slip] = sim->events.role[constraint->active] = GB_CONSTRAINED;
        sim->events.slip_of[constraint->slip] = sim->events.force_of[constraint->active] = i;
        if (constraint->free >= 0) {
            sim->events.role[constraint->free] = GB_SILENT;
        }
    }
    return sim;
}

void gb_close(gb_sim *sim) {
    if (sim) {
        free(sim->memory);
        free(sim);
    }
}

const gb_model *gb_model_of(const gb_sim *sim) {
    return sim->model;
}

double *gb_parameters(gb_sim *sim) {
    return sim->par;
}

double *gb_inputs(gb_sim *sim) {
    return sim->inputs.value;
}

void gb_changed(gb_sim *sim) {
    sim->head->changed = 1;
}
