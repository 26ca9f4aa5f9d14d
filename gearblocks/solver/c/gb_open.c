/* Memory, parameters, start, saved states. */
#include "gb_combine.h"
#include "gb_methods.h"
#include "gb_sparse.h"

#include <stdlib.h>

enum { LINE = 64 };

int gb_fail(gb_sim *sim, int code, int index, double t, double value) {
    const gb_report report = {code, index, t, value};
    sim->head->report = report;
    return code;
}

/* Fails with `code` and shift + the index of the first entry that is NaN or infinite. */
int gb_check_finite(gb_sim *sim, int code, const double *x, int count, int shift, double t) {
    for (int i = 0; i < count; i++) {
        if (!(x[i] - x[i] == 0.0)) {
            return gb_fail(sim, code, shift + i, t, x[i]);
        }
    }
    return GB_DONE;
}

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
    size_t at = 0;
    sim->head = take(base, &at, sizeof(gb_head));
    double **const by_switch[] = {&sim->mode,      &sim->lo,        &sim->hi,        &sim->on,   &sim->due,
                                  &sim->next_mode, &sim->next_time, &sim->flip_time, &sim->flips};
    double **const by_state[] = {&sim->peak, &sim->scale, &sim->noise, &sim->weight, &sim->floor};
    double **const whole[] = {&sim->y0, &sim->y, &sim->k1};
    sim->par = doubles(base, &at, m->n_par > m->n_parameters ? m->n_par : m->n_parameters);
    sim->input = doubles(base, &at, m->n_inputs);
    sim->cell = doubles(base, &at, m->n_inputs);
    sim->cell_end = doubles(base, &at, m->n_inputs);
    sim->lock_size = doubles(base, &at, m->n_locks);
    for (size_t i = 0; i < sizeof by_switch / sizeof by_switch[0]; i++) {
        *by_switch[i] = doubles(base, &at, m->n_switches + (i == 0 ? m->n_memory : 0));
    }
    for (size_t i = 0; i < sizeof by_state / sizeof by_state[0]; i++) {
        *by_state[i] = doubles(base, &at, m->n_padded);
    }
    for (size_t i = 0; i < sizeof whole / sizeof whole[0]; i++) {
        *whole[i] = doubles(base, &at, m->n_total);
    }
    sim->rows = doubles(base, &at, (long)GB_ROWS * m->n_total);
    return at;
}

/* What events need to decide about locks. */
static void lay_locks(gb_sim *sim, char *base, size_t *at) {
    const gb_model *m = sim->model;
    const long n = m->n_locks;
    double **const by_lock[] = {&sim->slip,        &sim->slip_rounding, &sim->lock_right, &sim->lock_lo,
                                &sim->lock_hi,     &sim->lock_force,    &sim->lock_other, &sim->lock_old,
                                &sim->lock_before, &sim->lock_bare,     &sim->lock_mode,  &sim->shrink,
                                &sim->base_mode,   &sim->base_sign,     &sim->best_mode,  &sim->best_rate};
    double **const by_pair[] = {&sim->response, &sim->lock_matrix, &sim->grip_inverse};
    int **const marks[] = {&sim->lock_index, &sim->lock_state, &sim->was_shared, &sim->released,
                           &sim->struck,     &sim->base_state, &sim->best_state, &sim->option};
    for (size_t i = 0; i < sizeof by_lock / sizeof by_lock[0]; i++) {
        *by_lock[i] = doubles(base, at, n);
    }
    for (size_t i = 0; i < sizeof by_pair / sizeof by_pair[0]; i++) {
        *by_pair[i] = doubles(base, at, n * n);
    }
    for (size_t i = 0; i < sizeof marks / sizeof marks[0]; i++) {
        *marks[i] = take(base, at, sizeof(int) * (size_t)(n + 1));
    }
    sim->limit = doubles(base, at, 5 * n);
    sim->other_mode = doubles(base, at, n > 0 ? m->n_switches + m->n_memory : 0);
    sim->grip = doubles(base, at, n * m->n_speeds);
    sim->grip_answer = doubles(base, at, n > 0 && m->pattern ? n * m->pattern->n : 0);
}

/* Scratch that may be forgotten between calls. Returns its size. */
static size_t lay_scratch(gb_sim *sim, char *base) {
    const gb_model *m = sim->model;
    size_t at = 0;
    double **const whole[] = {&sim->z, &sim->z2, &sim->zero};
    double **const by_surface[] = {&sim->s0, &sim->s, &sim->root, &sim->side};
    sim->k = doubles(base, &at, (long)GB_STAGES * m->n_total);
    for (size_t i = 0; i < sizeof whole / sizeof whole[0]; i++) {
        *whole[i] = doubles(base, &at, m->n_total);
    }
    for (size_t i = 0; i < sizeof by_surface / sizeof by_surface[0]; i++) {
        *by_surface[i] = doubles(base, &at, m->n_surfaces);
    }
    sim->slopes = doubles(base, &at, (long)GB_ROWS * m->n_affine);
    sim->before = doubles(base, &at, m->hold ? m->n_switches : 0);
    sim->samples = doubles(base, &at, (m->n_surfaces > m->n_affine ? (long)GB_STAGES : 0) * m->n_surfaces);
    sim->energy = doubles(base, &at, m->n_energies);
    sim->z_out = doubles(base, &at, m->n_outputs);
    sim->z_input = doubles(base, &at, m->n_inputs);
    sim->t = doubles(base, &at, GB_LANES);
    sim->t_one = doubles(base, &at, GB_LANES);
    sim->u = doubles(base, &at, (long)GB_LANES * m->n_inputs);
    sim->u_one = doubles(base, &at, (long)GB_LANES * m->n_inputs);
    sim->tau = doubles(base, &at, (long)GB_LANES * m->n_time);
    sim->tau_one = doubles(base, &at, (long)GB_LANES * m->n_time);
    if (m->pattern) {
        double **const by_unknown[] = {&sim->diag,    &sim->inverse,   &sim->work,
                                       &sim->unknown, &sim->leap_rate, &sim->leap_mass};
        for (size_t i = 0; i < sizeof by_unknown / sizeof by_unknown[0]; i++) {
            *by_unknown[i] = doubles(base, &at, m->pattern->n);
        }
        sim->lower = doubles(base, &at, m->pattern->n_places);
        sim->upper = doubles(base, &at, m->pattern->n_places);
        sim->kept = doubles(base, &at, m->n_kept);
        sim->n_colours = gb_colour_count(m->pattern);
        const size_t links = (size_t)sim->n_colours * (size_t)(m->n_simple + 1);
        sim->colour = take(base, &at, sizeof(int) * (size_t)(m->pattern->n + 1));
        sim->link = take(base, &at, sizeof(int) * links);
        sim->gain = take(base, &at, sizeof(double) * links);
    }
    sim->role = take(base, &at, sizeof(int) * (size_t)(m->n_switches + 1));
    lay_locks(sim, base, &at);
    sim->sources = take(base, &at, sizeof(gb_source) * (size_t)(m->n_inputs + 1));
    sim->moving = take(base, &at, sizeof(int) * (size_t)(m->n_inputs + 1));
    sim->log_capacity = 4L * m->n_switches + m->n_inputs + 64;
    sim->log = take(base, &at, sizeof(gb_event) * (size_t)sim->log_capacity);
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
    const size_t block = lay_block(sim, NULL), scratch = lay_scratch(sim, NULL);
    sim->memory = calloc(1, block + scratch + LINE);
    if (!sim->memory) {
        free(sim);
        return NULL;
    }
    char *base = sim->memory;
    base += LINE - (uintptr_t)base % LINE;
    sim->block_bytes = lay_block(sim, base);
    lay_scratch(sim, base + block);
    sim->head->key = hash_text(model->key);
    sim->head->bytes = block;
    for (int i = 0; i < model->n_locks; i++) {
        const gb_lock *lock = &model->locks[i];
        sim->role[lock->slip] = sim->role[lock->hold] = GB_LOCKED;
        if (lock->free >= 0) {
            sim->role[lock->free] = GB_SILENT;
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
    return sim->input;
}
void gb_changed(gb_sim *sim) {
    sim->head->changed = 1;
}

/* Derived parameters, natural scales and lanes of constants. */
static int take_values(gb_sim *sim, double t) {
    const gb_model *model = sim->model;
    int code = gb_check_finite(sim, GB_ERR_NAN_START, sim->par, model->n_parameters, model->n, t);
    if (code == GB_DONE) {
        code = gb_check_finite(sim, GB_ERR_NAN_INPUT, sim->input, model->n_inputs, 0, t);
    }
    if (code == GB_DONE) {
        model->prepare(sim->par);
        model->scales(sim->par, sim->scale);
        gb_size_locks(sim);
        gb_stiff_links(sim);
        gb_input_broadcast(sim);
        gb_input_find(sim, t, 0);
    }
    return code;
}

static void clear_run(gb_sim *sim, const gb_options *options, double t0) {
    const gb_model *m = sim->model;
    gb_head *head = sim->head;
    const gb_head fresh = {.key = head->key, .bytes = head->bytes, .options = *options};
    const size_t switches = sizeof(double) * (size_t)m->n_switches, states = sizeof(double) * (size_t)m->n_padded;
    *head = fresh;
    head->t_start = head->t0 = head->t1 = head->t_comm = t0;
    head->t_break = HUGE_VAL;
    head->row_due = 1;
    memset(sim->mode, 0, switches + sizeof(double) * (size_t)m->n_memory);
    memset(sim->on, 0, switches);
    memset(sim->due, 0, switches);
    memset(sim->flips, 0, switches);
    for (int i = 0; i < m->n_switches; i++) {
        sim->flip_time[i] = -HUGE_VAL;
    }
    memset(sim->peak, 0, states);
    memset(sim->scale, 0, states);
    memset(sim->noise, 0, states);
    memset(sim->weight, 0, states);
    memset(sim->floor, 0, states);
    gb_auto_start(sim);
    gb_set_method(sim, options->method == GB_AUTO ? head->explicit_method : options->method);
    sim->n_log = sim->n_flushed = 0;
}

int gb_start(gb_sim *sim, const gb_options *options, double t0, const double *y0) {
    const gb_model *model = sim->model;
    if (options->method < 0 || options->method > GB_AUTO) {
        return gb_fail(sim, GB_ERR_STATE, options->method, t0, 0.0);
    }
    if (options->method == GB_RODAS && !model->pattern) {
        return gb_fail(sim, GB_ERR_METHOD, options->method, t0, 0.0);
    }
    clear_run(sim, options, t0);
    int code = take_values(sim, t0);
    if (code == GB_DONE) {
        memset(sim->y, 0, sizeof(double) * (size_t)model->n_total);
        gb_time_modes(sim, 0);
        code = gb_columns_at(sim, t0);
    }
    if (code == GB_DONE) {
        model->start(sim->par, sim->mode, sim->tau_one, sim->y);
        if (y0) {
            memcpy(sim->y, y0, sizeof(double) * (size_t)model->n_total);
        }
        code = gb_check_finite(sim, GB_ERR_NAN_START, sim->y, model->n, 0, t0);
    }
    if (code == GB_DONE) {
        gb_turns_wrap(sim, 0);
        gb_weights_grow(sim, sim->y);
        code = gb_modes_start(sim, y0 == NULL);
    }
    sim->head->started = code == GB_DONE;
    return code;
}

/* Written parameters or inputs take effect: the run restarts from the communication point. */
int gb_apply_changes(gb_sim *sim) {
    const gb_model *model = sim->model;
    gb_head *head = sim->head;
    if (!head->changed || !head->started) {
        return head->report.code;
    }
    gb_dense_all(sim, head->t_comm, sim->z);
    if (head->t_comm < head->t1) {
        const double share = head->h > 0.0 ? (head->t_comm - head->t0) / (head->t1 - head->t0) : 1.0;
        head->turnover -= (1.0 - share) * head->turnover_segment;
        head->pending = 0;
        memset(sim->due, 0, sizeof(double) * (size_t)sim->model->n_switches);
    }
    memcpy(sim->y, sim->z, sizeof(double) * (size_t)sim->model->n_total);
    head->t0 = head->t1 = head->t_comm;
    head->h = 0.0;
    head->have_dense = head->have_tail = head->have_k1 = head->changed = 0;
    head->h_weights = 0.0;
    head->floor_at = 0;
    head->log_error = 0.0;
    head->report.code = GB_DONE;
    int code = take_values(sim, head->t1);
    if (code == GB_DONE) {
        gb_time_modes(sim, 1);
        code = gb_settle(sim, 1);
    }
    if (code == GB_DONE && model->n_locks > 0) {
        code = gb_settle_locks(sim, 1);
    }
    return code;
}

size_t gb_snapshot_size(const gb_sim *sim) {
    return sim->block_bytes;
}
void gb_save(const gb_sim *sim, void *block) {
    memcpy(block, sim->head, sim->block_bytes);
}

int gb_restore(gb_sim *sim, const void *block) {
    gb_head other;
    memcpy(&other, block, sizeof other);
    if (other.key != sim->head->key || other.bytes != sim->head->bytes) {
        return gb_fail(sim, GB_ERR_STATE, 0, sim->head->t1, (double)other.bytes);
    }
    memcpy(sim->head, block, sim->block_bytes);
    sim->method = &gb_method_table[sim->head->method];
    sim->n_log = sim->n_flushed = 0;
    gb_stiff_links(sim);
    gb_input_broadcast(sim);
    return GB_DONE;
}

void gb_get_stats(const gb_sim *sim, gb_stats *stats) {
    const gb_head *head = sim->head;
    const gb_stats now = {.t = head->t1,
                          .step = head->options.step > 0.0 ? head->options.step : head->h_next,
                          .turnover = head->turnover,
                          .steps = head->steps,
                          .rejected = head->rejected,
                          .rhs_calls = head->rhs_calls,
                          .events = head->events,
                          .jacobians = head->jacobians,
                          .method = head->method,
                          .n_switches = head->n_switches};
    *stats = now;
    memcpy(stats->steps_by, head->steps_by, sizeof stats->steps_by);
    memcpy(stats->switch_method, head->switch_method, sizeof stats->switch_method);
    memcpy(stats->switch_t, head->switch_t, sizeof stats->switch_t);
}

void gb_get_report(const gb_sim *sim, gb_report *report) {
    *report = sim->head->report;
}
