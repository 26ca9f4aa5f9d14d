/* P1's right-hand side as a person writes it; its own file, so that nothing is inlined. */
#include "p1_rates.h"

#include <math.h>

static inline void slopes(const double *par, const double *mode, double wave, const double *y, double *dy) {
    const p1_numbers *p = (const p1_numbers *)par;
    const double side = mode[0];
    const double stiffness = p->k_mesh * (1 + p->ripple * wave) * (side * side);
    const double left = p->k_shaft * y[0] + p->c_left * (y[3] - y[4]);
    const double mesh = p->c_mesh * (y[4] - y[5]) + stiffness * (y[1] - side * p->half_gap);
    const double right = p->k_shaft * y[2] + p->c_right * (y[5] - y[6]);
    dy[0] = y[3] - y[4];
    dy[1] = y[4] - y[5];
    dy[2] = y[5] - y[6];
    dy[3] = p->per_inertia[0] * (p->torque * (1 + p->swing * wave) - left);
    dy[4] = p->per_inertia[1] * (left - mesh);
    dy[5] = p->per_inertia[2] * (mesh - right);
    dy[6] = p->per_inertia[3] * (right - p->torque);
}

void p1_rates(const double *par, const double *mode, const double *tau, const double *y, double *dy) {
    slopes(par, mode, tau[0], y, dy);
}

void p1_rates_at(const double *par, const double *mode, const double *t, const double *y, double *dy) {
    const p1_numbers *p = (const p1_numbers *)par;
    slopes(par, mode, cos(p->w * t[0]), y, dy);
}
