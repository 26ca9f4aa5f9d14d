#include "gb_angle_wrapping.h"
#include "gb_double_double.h"
#include "gb_evaluate.h"
#include "gb_implicit_angles.h"
#include "gb_modes.h"

/* No step turns a wrapped angle by more than this: the digits of an angle inside a step are those of its size. */
static const double most_turns = 1024.0;

/* The weights of the rates in row `row` of a step (the first: in its end). An angle of an implicit step whose speed is
 * no state follows from the rates at the nodes of its quadratures (gb_rosenbrock_quadratures puts the first one in
 * place): its stages are no rates. */
static const gb_weights *weights_of(const gb_method *method, int row) {
    if (method->gamma > 0.0) {
        return &method->quadratures[row];
    }
    return row < 3 ? &method->a[method->stages] : &method->d[row];
}

/* h sum w (k - k1): exactly zero at constant speed. */
static double departure(const gb_sim *sim, const gb_wrapped *wrapped, int row, double h) {
    const gb_weights *w = weights_of(sim->method, row);
    const int i = wrapped->state;
    if (sim->method->gamma > 0.0 && wrapped->speed >= 0) {
        return gb_angle_bend(sim, row, wrapped->speed, h);
    }
    const size_t total = (size_t)sim->model->n_total;
    double sum = 0.0;
    for (int j = 0; j < w->count; j++) {
        sum += w->value[j] * (sim->k[(size_t)w->index[j] * total + (size_t)i] - sim->k[i]);
    }
    return h * sum;
}

double gb_wrapping_step(const gb_sim *sim, double h) {
    for (int c = 0; c < sim->model->n_wrapped; c++) {
        const double speed = fabs(sim->k1[sim->model->wrapped[c].state]);
        if (h * speed > most_turns * gb_turn) {
            h = most_turns * gb_turn / speed;
        }
    }
    return h;
}

void gb_wrapping_advance(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int c = 0; c < model->n_wrapped; c++) {
        const int i = model->wrapped[c].state, quadrature = model->n_padded + 2 * c;
        double hi = sim->y0[i], lo = sim->y0[quadrature + 1], product, rest;
        gb_multiply_two(sim->head->front.h, sim->k[i], &product, &rest);
        gb_add_two(&hi, &lo, product);
        gb_add_two(&hi, &lo, departure(sim, &model->wrapped[c], 0, sim->head->front.h));
        lo += rest;
        gb_settle_two(&hi, &lo);
        sim->y[i] = hi;
        sim->y[quadrature + 1] = lo;
    }
}

void gb_wrapping_rows(gb_sim *sim, int from, int to) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    const size_t total = (size_t)model->n_total;
    const double h = sim->head->front.h;
    for (int c = 0; c < model->n_wrapped; c++) {
        const int i = model->wrapped[c].state;
        double *row = sim->rows + i;
        for (int m = from; m < to; m++) {
            const double bend = departure(sim, &model->wrapped[c], m, h);
            if (method->gamma > 0.0) {
                row[(size_t)m * total] = m == 0 ? h * sim->k[i] + bend : bend;
                continue;
            }
            const double gain = h * (sim->k[i] - sim->k[(size_t)method->stages * total + (size_t)i]);
            row[(size_t)m * total] =
                m == 0 ? h * sim->k[i] + bend : (m == 1 ? -bend : (m == 2 ? 2.0 * bend + gain : bend));
        }
    }
}

/* Whether a switch over a wrapped angle is so close to a limit that its side could be lost to rounding. */
static int on_a_limit(const gb_sim *sim, const gb_wrapped *wrapped) {
    for (int j = 0; j < wrapped->n_switches; j++) {
        const int i = wrapped->switches[j];
        const double s = sim->events.s[i], rounding = 1e-12 * (fabs(s) + fabs(wrapped->steps[j]) + 1.0);
        if (s < sim->events.lo[i] + rounding || s > sim->events.hi[i] - rounding) {
            return 1;
        }
    }
    return 0;
}

static int wrap(gb_sim *sim, int c, int with_modes) {
    const gb_wrapped *wrapped = &sim->model->wrapped[c];
    const int quadrature = sim->model->n_padded + 2 * c;
    double *angle = &sim->y[wrapped->state];
    if (fabs(*angle) <= 0.75 * gb_turn * wrapped->turns) {
        return GB_DONE;
    }
    if (with_modes && wrapped->n_switches > 0) {
        const int code = gb_event_functions_now(sim);
        if (code != GB_DONE || on_a_limit(sim, wrapped)) {
            return code;
        }
    }
    const double turns = gb_whole_turns(*angle, wrapped->turns);
    gb_take_turns(angle, &sim->y[quadrature + 1], turns);
    sim->y[quadrature] += turns;
    if (with_modes && wrapped->n_switches > 0) {
        for (int j = 0; j < wrapped->n_switches; j++) {
            const int i = wrapped->switches[j];
            gb_set_mode(sim, i, sim->mode[i] - turns / wrapped->turns * wrapped->steps[j], 0);
        }
        gb_mode_limits(sim);
    }
    return GB_DONE;
}

int gb_wrap_angles(gb_sim *sim, int with_modes) {
    int code = GB_DONE;
    for (int c = 0; c < sim->model->n_wrapped && code == GB_DONE; c++) {
        code = wrap(sim, c, with_modes);
    }
    return code;
}
