/* P2: one gear pair without dimensions, x'' + 2 z x' + (1 + eps cos w t) g(x) = Fm + Fah w^2 cos w t. */
typedef struct problem {
    double half_gap;
    double damping, ripple, load, swing, w; /* 2 z, eps, Fm, Fah w^2, w */
} problem;

#define DIM(p) ((void)(p), 2)
#define GAPS(p) ((void)(p), 1)
#include "real.h"

static inline void rates(const problem *p, const real *side, real t, const real *y, real *dy) {
    const real wave = cos(p->w * t), contact = side[0] * side[0];
    const real force = (1 + p->ripple * wave) * contact * (y[0] - side[0] * p->half_gap);
    dy[0] = y[1];
    dy[1] = p->load + p->swing * wave - p->damping * y[1] - force;
}

static inline void gaps(const problem *p, const real *y, real *s) {
    (void)p;
    s[0] = y[0];
}

#include "solve.h"

int p2_solve(const problem *p, const double *start, const double *side, const double *scale, double first_step,
             double rtol, int n_out, const double *t_out, double *out, long *count) {
    return solve(p, start, side, scale, first_step, rtol, n_out, t_out, out, count);
}
