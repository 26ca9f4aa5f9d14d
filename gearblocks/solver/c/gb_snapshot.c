#include "gb_snapshot.h"
#include "gb_constraint_state.h"
#include "gb_inputs.h"
#include "gb_memory.h"
#include "gb_report.h"
#include "gb_rosenbrock.h"

unsigned long long gb_checksum(const void *bytes, size_t count, unsigned long long seed) {
    const char *from = bytes;
    uint64_t sum = seed ^ (0x9e3779b97f4a7c15u * ((uint64_t)count + 1u));
    while (count > 0) {
        const size_t part = count < sizeof sum ? count : sizeof sum;
        uint64_t word = 0;
        memcpy(&word, from, part);
        sum = (sum ^ word) * 0xd6e8feb86659fd93u;
        sum ^= sum >> 32;
        from += part;
        count -= part;
    }
    return sum;
}

/* Of a whole block, its own place left out. */
static uint64_t checksum_of(const char *block, size_t bytes) {
    const size_t at = offsetof(gb_head, checksum), after = at + sizeof(uint64_t);
    return gb_checksum(block + after, bytes - after, gb_checksum(block, at, 0));
}

/* Whether `count` numbers are finite, at the place in the block that `own` has in the simulation's. */
static int finite_in(const gb_sim *sim, const char *block, const double *own, int count) {
    const char *at = block + ((const char *)own - (const char *)sim->head);
    for (int i = 0; i < count; i++) {
        double x;
        memcpy(&x, at + sizeof x * (size_t)i, sizeof x); /* a block may lie anywhere */
        if (!(fabs(x) <= DBL_MAX)) {
            return 0;
        }
    }
    return 1;
}

static int options_fit(const gb_sim *sim, const gb_options *options) {
    return options->method >= 0 && options->method <= GB_AUTO && (options->locate == 0 || options->locate == 1) &&
           (options->method != GB_RODAS || sim->model->pattern) && options->rtol > 0.0 && options->rtol <= 1.0 &&
           options->step >= 0.0 && options->step <= DBL_MAX && options->max_step > 0.0 &&
           options->t_stop == options->t_stop;
}

static int sliding_fits(const gb_sim *sim, const struct gb_event_state *events) {
    int fits = events->n_sliding >= 0 && events->n_sliding <= GB_SLIDING;
    for (int j = 0; fits && j < events->n_sliding; j++) {
        fits = events->sliding[j] >= 0 && events->sliding[j] < sim->model->n_event_functions &&
               events->resting[j] >= GB_HELD && events->resting[j] < sim->model->n_constraints;
    }
    return fits;
}

/* What the solver takes for granted of its block: numbers that choose from tables, order of times, finite states. */
static int head_fits(const gb_sim *sim, const gb_head *head) {
    const struct gb_front *front = &head->front;
    const struct gb_choice *choice = &head->choice;
    const int last = sim->model->pattern ? GB_METHODS - 1 : GB_RODAS - 1;
    return options_fit(sim, &head->options) && head->method >= 0 && head->method <= last &&
           choice->explicit_method >= 0 && choice->explicit_method < GB_RODAS && choice->n_switches >= 0 &&
           (head->started == 0 || head->started == 1) && (head->changed == 0 || head->changed == 1) &&
           fabs(front->t_start) <= DBL_MAX && front->t_start <= front->t0 && front->t0 <= front->t_comm &&
           front->t_comm <= front->t1 && front->t1 <= DBL_MAX && front->h >= 0.0 && front->h <= DBL_MAX &&
           front->sample >= 0 && head->control.h_next >= 0.0 && head->control.h_next <= DBL_MAX &&
           head->counts.steps >= 0 && head->counts.rejected >= 0 && head->counts.events >= 0 &&
           head->events.t_break == head->events.t_break && sliding_fits(sim, &head->events);
}

/* The active set in a block: constraints in ascending order. */
static int active_set_fits(const gb_sim *sim, const char *block) {
    const int n = sim->model->n_constraints;
    const char *at = block + ((const char *)(sim->mode + sim->model->n_switches) - (const char *)sim->head);
    double count = 0.0, last = -1.0;
    if (n > 0) {
        memcpy(&count, at + sizeof count * GB_ACTIVE_COUNT, sizeof count);
    }
    for (int i = 0; count > 0.0 && i < n && i < count; i++) {
        double index;
        memcpy(&index, at + sizeof index * (size_t)(GB_ACTIVE_INDEX + i), sizeof index);
        if (!(index > last && index < n && index == floor(index))) {
            return 0;
        }
        last = index;
    }
    return count >= 0.0 && count <= n && count == floor(count);
}

static int block_fits(const gb_sim *sim, const char *block) {
    const gb_model *model = sim->model;
    gb_head head;
    memcpy(&head, block, sizeof head);
    return head.key == sim->head->key && head.bytes == sim->head->bytes &&
           head.checksum == checksum_of(block, sim->block_bytes) &&
           (!head.started ||
            (head_fits(sim, &head) && finite_in(sim, block, sim->y, model->n_total) &&
             finite_in(sim, block, sim->mode, model->n_switches + model->n_active_set) && active_set_fits(sim, block)));
}

size_t gb_snapshot_size(const gb_sim *sim) {
    return sim->block_bytes;
}

void gb_save(const gb_sim *sim, void *block) {
    char *bytes = block;
    memcpy(bytes, sim->head, sim->block_bytes);
    const uint64_t checksum = checksum_of(bytes, sim->block_bytes);
    memcpy(bytes + offsetof(gb_head, checksum), &checksum, sizeof checksum);
}

int gb_fits(const gb_sim *sim, const void *block) {
    return block_fits(sim, block);
}

int gb_restore(gb_sim *sim, const void *block) {
    if (!block_fits(sim, block)) {
        return gb_fail(sim, GB_ERR_STATE, 0, sim->head->front.t1, 0.0);
    }
    memcpy(sim->head, block, sim->block_bytes);
    gb_set_method(sim, sim->head->method);
    sim->panel.known = 0;
    if (gb_some_active(sim)) {
        sim->model->renew_active_set(sim->par, sim->mode);
    }
    sim->log.count = sim->log.flushed = 0;
    gb_kinematic_links(sim);
    gb_input_broadcast(sim);
    return GB_DONE;
}
