/* P1 by hand, with the signature of a generated right-hand side. */
#ifndef P1_RATES_H
#define P1_RATES_H

typedef struct p1_numbers {
    double half_gap;
    double per_inertia[4], k_shaft, c_left, c_right, k_mesh, ripple, c_mesh, torque, swing, w;
} p1_numbers;

/* With cos(w t) given in tau[0]. */
void p1_rates(const double *par, const double *mode, const double *tau, const double *y, double *dy);

/* With the time given in t[0]. */
void p1_rates_at(const double *par, const double *mode, const double *t, const double *y, double *dy);

#endif
