#include "gb_implicit_angles.h"

enum { ROWS = GB_NODES + 2 };

double gb_angle_bend(const gb_sim *sim, int m, int speed, double h) {
    const double *weight = sim->method->angles[m], *k = sim->k + speed;
    double sum = 0.0;
    for (int j = 0; j < sim->method->stages; j++) {
        sum += weight[j] * k[(size_t)j * (size_t)sim->model->n_total];
    }
    return h * (h * sum);
}

/* The state that is the rate of quadrature i, -1: none. */
static int speed_of(const gb_model *model, int i) {
    return model->angle_speed ? model->angle_speed[i] : -1;
}

void gb_implicit_angles(const gb_sim *sim, double theta, double h, double *y) {
    const gb_model *model = sim->model;
    for (int i = 0; i < model->n_angles; i++) {
        const int speed = speed_of(model, i);
        if (speed < 0) {
            continue;
        }
        double sum = 0.0;
        for (int m = theta < 1.0 ? ROWS - 1 : 0; m >= 0; m--) {
            sum = gb_angle_bend(sim, m, speed, h) + (m % 2 == 0 ? 1.0 - theta : theta) * sum;
        }
        y[model->n_padded + i] = sim->y0[model->n_padded + i] + theta * (h * sim->y0[speed] + sum);
    }
}

void gb_implicit_angle_rows(gb_sim *sim) {
    const gb_model *model = sim->model;
    const double h = sim->head->front.h;
    for (int i = 0; i < model->n_angles; i++) {
        const int speed = speed_of(model, i);
        for (int m = 0; m < ROWS && speed >= 0; m++) {
            sim->rows[(size_t)m * (size_t)model->n_total + (size_t)(model->n_padded + i)] =
                gb_angle_bend(sim, m, speed, h) + (m == 0 ? h * sim->y0[speed] : 0.0);
        }
    }
}
