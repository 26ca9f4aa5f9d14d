/* P1: four discs, two shafts and a spline mesh with backlash, driven by time.
 * States: twists phi1 - phi2, phi2 - phi3, phi3 - phi4, speeds w1 .. w4, one zero to fill the vector. */
typedef struct problem {
    double half_gap; /* of the mesh, rad */
    double per_inertia[4], k_shaft, c_left, c_right, k_mesh, ripple, c_mesh, torque, swing, w;
} problem;

#define DIM(p) ((void)(p), 8)
#define GAPS(p) ((void)(p), 1)
#include "real.h"

static inline void rates(const problem *p, const real *side, real t, const real *y, real *dy) {
    const real wave = cos(p->w * t), contact = side[0] * side[0];
    const real stiffness = p->k_mesh * (1 + p->ripple * wave) * contact;
    const real left = p->k_shaft * y[0] + p->c_left * (y[3] - y[4]);
    const real mesh = p->c_mesh * (y[4] - y[5]) + stiffness * (y[1] - side[0] * p->half_gap);
    const real right = p->k_shaft * y[2] + p->c_right * (y[5] - y[6]);
    dy[0] = y[3] - y[4];
    dy[1] = y[4] - y[5];
    dy[2] = y[5] - y[6];
    dy[3] = p->per_inertia[0] * (p->torque * (1 + p->swing * wave) - left);
    dy[4] = p->per_inertia[1] * (left - mesh);
    dy[5] = p->per_inertia[2] * (mesh - right);
    dy[6] = p->per_inertia[3] * (right - p->torque);
    dy[7] = 0;
}

static inline void gaps(const problem *p, const real *y, real *s) {
    (void)p;
    s[0] = y[1];
}

#include "solve.h"

int p1_solve(const problem *p, const double *start, const double *side, const double *scale, double first_step,
             double rtol, int n_out, const double *t_out, double *out, long *count) {
    return solve(p, start, side, scale, first_step, rtol, n_out, t_out, out, count);
}
