#include "gb_runge_kutta.h"
#include "gb_rates.h"
#include "gb_stage_modes.h"
#include "gb_vector.h"

/* Whether something slides is asked once: `slides` is a constant where this is inlined. */
GB_INLINE void run_stages(gb_sim *sim, double h, int slides) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    const int total = model->n_total, padded = model->n_padded;
    for (int j = 1; j < method->stages; j++) {
        double *rates = sim->k + (size_t)j * (size_t)total;
        gb_combine(&method->a[j], sim->k, total, 0, padded, sim->y0, h, sim->z);
        if (slides) {
            gb_sliding_rates(sim, method->full[j], &sim->lanes, j, sim->z, rates);
        } else {
            gb_mode_rates(sim, method->full[j], &sim->lanes, j, sim->z, rates);
        }
    }
    gb_combine(&method->a[method->stages], sim->k, total, 0, total, sim->y0, h, sim->z);
    sim->head->counts.rhs_calls += method->stages - 1;
}

void gb_run_stages(gb_sim *sim, double h) {
    if (sim->head->events.n_sliding > 0) {
        run_stages(sim, h, 1);
    } else {
        run_stages(sim, h, 0);
    }
}

void gb_run_extra_stages(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    for (int j = method->stages + 1; j < method->all_stages; j++) {
        gb_combine(&method->a[j], sim->k, model->n_total, 0, model->n_padded, sim->y0, h, sim->z2);
        gb_rates(sim, 1, &sim->lanes, j, sim->z2, sim->k + (size_t)j * (size_t)model->n_total);
        sim->head->counts.rhs_calls++;
    }
}

void gb_run_stages_unlocated(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    const int total = model->n_total, padded = model->n_padded;
    gb_stage_modes_begin(sim, method->all_stages);
    for (int j = 1; j < method->stages; j++) {
        gb_combine(&method->a[j], sim->k, total, 0, padded, sim->y0, h, sim->z);
        gb_stage_rates(sim, j, method->full[j], sim->z, sim->k + (size_t)j * (size_t)total);
    }
    gb_combine(&method->a[method->stages], sim->k, total, 0, total, sim->y0, h, sim->z);
    sim->head->counts.rhs_calls += method->stages - 1;
}

void gb_run_extra_stages_unlocated(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const gb_method *method = sim->method;
    for (int j = method->stages + 1; j < method->all_stages; j++) {
        gb_combine(&method->a[j], sim->k, model->n_total, 0, model->n_padded, sim->y0, h, sim->z2);
        gb_stage_rates(sim, j, 1, sim->z2, sim->k + (size_t)j * (size_t)model->n_total);
        sim->head->counts.rhs_calls++;
    }
}
