#include "gb_rounding_motion.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* sum |E_i| at a state, in the present modes at the front. */
static double energy_at(gb_sim *sim, const double *y) {
    double sum = 0.0;
    sim->model->energies(sim->par, sim->mode, sim->instant.time_terms, y, sim->scratch.energies);
    for (int i = 0; i < sim->model->n_energies; i++) {
        sum += fabs(sim->scratch.energies[i]);
    }
    return sum;
}

/* The speed that is taken for rounding: what the noise of its rate makes in the run so far; and less than the last bit
 * of 1 rad (of 1 m) in all of it, which a friction leaves whose capacity passes 0 beside a body at rest. */
static double rounding_of_speed(const gb_sim *sim, int i) {
    const double time = sim->head->front.t1 - sim->head->front.t_start;
    return time > 0.0 ? gb_max(time * sim->control.noise[i], DBL_EPSILON / time) : 0.0;
}

int gb_moves_by_rounding(const gb_sim *sim) {
    for (int i = sim->model->n - sim->model->n_speeds; i < sim->model->n; i++) {
        if (!(sim->control.largest[i] <= rounding_of_speed(sim, i))) {
            return 0;
        }
    }
    return 1;
}

double gb_rounding_energy(gb_sim *sim) {
    const gb_model *model = sim->model;
    double energy[2] = {0.0, 0.0}; /* of speeds that are taken for rounding, and of the largest that there were */
    if (gb_time_terms_at(sim, sim->head->front.t1) != GB_DONE) {
        return 0.0;
    }
    memcpy(sim->z2, sim->y, sizeof(double) * (size_t)model->n_total);
    for (int which = 0; which < 2; which++) {
        for (int i = model->n - model->n_speeds; i < model->n; i++) {
            sim->z2[i] = which == 0 ? rounding_of_speed(sim, i) : sim->control.largest[i];
        }
        energy[which] = energy_at(sim, sim->z2);
    }
    return energy[1] <= energy[0] ? gb_max(energy[0] - energy_at(sim, sim->y), 0.0) : 0.0;
}
