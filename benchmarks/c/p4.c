/* P4: a chain of N inertias, heavy and light ones in turn, tied by shafts and meshes in turn, the last to ground.
 * States: twists (phi_i - phi_{i+1}), then speeds. Couplings 1, 3, 5, ... but for the last one are meshes. */
typedef struct problem {
    double half_gap; /* rad */
    double j_heavy, j_light, k_shaft, c_shaft, k_mesh, c_mesh, torque, swing, w;
    double inertias; /* N, even */
} problem;

#define DIM(p) (2 * (int)(p)->inertias)
#define GAPS(p) ((int)(p)->inertias / 2 - 1)
#include "real.h"

static inline void rates(const problem *p, const real *side, real t, const real *y, real *dy) {
    const int n = (int)p->inertias;
    const real per_heavy = 1 / (real)p->j_heavy, per_light = 1 / (real)p->j_light;
    const real *restrict twist = y, *restrict w = y + n;
    real *restrict dw = dy + n;
    real from = p->torque * (1 + p->swing * sin(p->w * t));
    for (int i = 0; i < n; i += 2) {
        const real after = i + 2 < n ? w[i + 2] : 0, between = side[i + 2 < n ? i / 2 : 0];
        const real shaft = p->k_shaft * twist[i] + p->c_shaft * (w[i] - w[i + 1]);
        const real mesh =
            p->c_mesh * (w[i + 1] - after) + p->k_mesh * between * between * (twist[i + 1] - between * p->half_gap);
        const real last = p->k_shaft * twist[i + 1] + p->c_shaft * w[i + 1];
        const real to = i + 2 < n ? mesh : last;
        dy[i] = w[i] - w[i + 1];
        dy[i + 1] = w[i + 1] - after;
        dw[i] = per_heavy * (from - shaft);
        dw[i + 1] = per_light * (shaft - to);
        from = to;
    }
}

static inline void gaps(const problem *p, const real *y, real *s) {
    for (int i = 0; i < GAPS(p); i++)
        s[i] = y[2 * i + 1];
}

#ifdef WITH_CVODE
#include "cvode.h"

static long nonzeros(const problem *p) {
    return 8 * (long)p->inertias - 4;
}

static void jacobian(const problem *p, const double *side, double t, const double *y, sunindextype *start,
                     sunindextype *row, double *value) {
    const sunindextype n = (sunindextype)p->inertias;
    const double per[2] = {1 / p->j_heavy, 1 / p->j_light};
    sunindextype at = 0;
    (void)t, (void)y;
    for (sunindextype i = 0; i < n; i++) { /* twist i pulls on discs i and i + 1 */
        const int mesh = i % 2 == 1 && i < n - 1;
        const double k = !mesh ? p->k_shaft : side[i / 2] * side[i / 2] * p->k_mesh;
        start[i] = at;
        row[at] = i, value[at++] = 0;
        row[at] = n + i, value[at++] = -per[i % 2] * k;
        if (i < n - 1)
            row[at] = n + i + 1, value[at++] = per[(i + 1) % 2] * k;
    }
    double before = 0;
    for (sunindextype i = 0; i < n; i++) { /* speed i */
        const double c = i % 2 == 1 && i < n - 1 ? p->c_mesh : p->c_shaft;
        start[n + i] = at;
        if (i > 0)
            row[at] = i - 1, value[at++] = -1;
        row[at] = i, value[at++] = 1;
        if (i > 0)
            row[at] = n + i - 1, value[at++] = per[(i - 1) % 2] * before;
        row[at] = n + i, value[at++] = -per[i % 2] * (before + c);
        if (i < n - 1)
            row[at] = n + i + 1, value[at++] = per[(i + 1) % 2] * c;
        before = c;
    }
    start[2 * n] = at;
}

int p4_cvode(const problem *p, const double *start, const double *scale, double rtol, int n_out, const double *t_out,
             double *out, long *count) {
    return by_cvode(p, start, scale, rtol, n_out, t_out, out, count);
}
#else
#include "solve.h"

int p4_solve(const problem *p, const double *start, const double *side, const double *scale, double first_step,
             double rtol, int n_out, const double *t_out, double *out, long *count) {
    return solve(p, start, side, scale, first_step, rtol, n_out, t_out, out, count);
}
#endif
