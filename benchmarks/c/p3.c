/* P3: a planetary set with four planets. States: deflections x_i of the sun meshes, u (a ring mesh deflects by
 * x_i - u), angle of the ring; speeds of sun, carrier, ring and planets; zeros to fill the vector. */
typedef struct problem {
    double half_gap;
    double r_sun, r_planet, r_ring;
    double per_sun, per_carrier, per_ring, per_planet; /* 1/J */
    double k_sun, k_ring, c_sun, c_ring, ripple, k_ground, c_ground;
    double torque, load, swing, w;
    double wave_cos[8], wave_sin[8]; /* of the phases: sun meshes, ring meshes */
} problem;

enum { STATES = 13, PLANETS = 4, U = 4, RING = 5, W_SUN = 6, W_CARRIER = 7, W_RING = 8, W_PLANET = 9 };

#ifdef WITH_CVODE
#define DIM(p) ((void)(p), STATES)
#else
#define DIM(p) ((void)(p), 16)
#endif
#define GAPS(p) ((void)(p), 8)
#include "real.h"

static inline real stiffness(const problem *p, int mesh, real side, real wave, real slope) {
    const real mean = mesh < PLANETS ? p->k_sun : p->k_ring;
    return mean * (1 + p->ripple * (wave * p->wave_cos[mesh] - slope * p->wave_sin[mesh])) * side * side;
}

static inline void rates(const problem *p, const real *side, real t, const real *y, real *dy) {
    const real wave = cos(p->w * t), slope = sin(p->w * t), b = p->half_gap;
    const real sun = p->r_sun * (y[W_SUN] - y[W_CARRIER]), ring = p->r_ring * (y[W_RING] - y[W_CARRIER]);
    real at_sun = 0, at_ring = 0;
#pragma GCC unroll 4
    for (int i = 0; i < PLANETS; i++) {
        const real planet = p->r_planet * (y[W_PLANET + i] - y[W_CARRIER]);
        const real f = p->c_sun * (sun + planet) + stiffness(p, i, side[i], wave, slope) * (y[i] - side[i] * b);
        const real g = p->c_ring * (planet - ring) +
                       stiffness(p, i + 4, side[i + 4], wave, slope) * (y[i] - y[U] - side[i + 4] * b);
        dy[i] = sun + planet;
        dy[W_PLANET + i] = -p->per_planet * p->r_planet * (f + g);
        at_sun += f;
        at_ring += g;
    }
    dy[U] = sun + ring;
    dy[RING] = y[W_RING];
    dy[W_SUN] = p->per_sun * (p->torque * (1 + p->swing * wave) - p->r_sun * at_sun);
    dy[W_CARRIER] =
        p->per_carrier * ((p->r_sun + p->r_planet) * at_sun - (p->r_ring - p->r_planet) * at_ring - p->load);
    dy[W_RING] = p->per_ring * (p->r_ring * at_ring - p->k_ground * y[RING] - p->c_ground * y[W_RING]);
    for (int i = STATES; i < DIM(p); i++)
        dy[i] = 0;
}

static inline void gaps(const problem *p, const real *y, real *s) {
    (void)p;
    for (int i = 0; i < PLANETS; i++) {
        s[i] = y[i];
        s[i + 4] = y[i] - y[U];
    }
}

#ifdef WITH_CVODE
#include "cvode.h"

/* Rows of each column that can be non-zero, one bit each. */
static const unsigned rows_of[STATES] = {
    0x3C1, 0x5C2, 0x9C4, 0x11C8, 0x1F90, 0x120, 0x1EDF, 0x1FDF, 0x1FB0, 0x3C1, 0x5C2, 0x9C4, 0x11C8,
};

static long nonzeros(const problem *p) {
    long count = 0;
    for (int j = 0; j < DIM(p); j++)
        for (unsigned bits = rows_of[j]; bits; bits &= bits - 1)
            count++;
    return count;
}

/* Adds what one mesh contributes: slope[] its force over the states, lever[] the force on each speed. */
static void spread(double full[STATES][STATES], const double *slope, const double *lever) {
    for (int j = 0; j < STATES; j++)
        for (int i = W_SUN; i < STATES; i++)
            full[j][i] += lever[i] * slope[j];
}

static void jacobian(const problem *p, const double *side, double t, const double *y, sunindextype *start,
                     sunindextype *row, double *value) {
    const double wave = cos(p->w * t), along = sin(p->w * t), rs = p->r_sun, rp = p->r_planet, rr = p->r_ring;
    double full[STATES][STATES] = {{0}}; /* by column */
    (void)y;
    for (int i = 0; i < PLANETS; i++) {
        const double ks = stiffness(p, i, side[i], wave, along), kr = stiffness(p, i + 4, side[i + 4], wave, along);
        double slope[STATES] = {0}, lever[STATES] = {0};
        slope[i] = ks;
        slope[W_SUN] = p->c_sun * rs;
        slope[W_CARRIER] = -p->c_sun * (rs + rp);
        slope[W_PLANET + i] = p->c_sun * rp;
        lever[W_SUN] = -p->per_sun * rs;
        lever[W_CARRIER] = p->per_carrier * (rs + rp);
        lever[W_PLANET + i] = -p->per_planet * rp;
        spread(full, slope, lever);
        slope[i] = kr;
        slope[U] = -kr;
        slope[W_SUN] = lever[W_SUN] = 0;
        slope[W_RING] = -p->c_ring * rr;
        slope[W_CARRIER] = p->c_ring * (rr - rp);
        slope[W_PLANET + i] = p->c_ring * rp;
        lever[W_RING] = p->per_ring * rr;
        lever[W_CARRIER] = -p->per_carrier * (rr - rp);
        spread(full, slope, lever);
        full[W_SUN][i] = rs;
        full[W_CARRIER][i] = -rs - rp;
        full[W_PLANET + i][i] = rp;
    }
    full[W_SUN][U] = rs;
    full[W_CARRIER][U] = -rs - rr;
    full[W_RING][U] = rr;
    full[W_RING][RING] = 1;
    full[RING][W_RING] -= p->per_ring * p->k_ground;
    full[W_RING][W_RING] -= p->per_ring * p->c_ground;
    sunindextype at = 0;
    for (int j = 0; j < STATES; j++) {
        start[j] = at;
        for (int i = 0; i < STATES; i++)
            if (rows_of[j] >> i & 1) {
                row[at] = i;
                value[at++] = full[j][i];
            }
    }
    start[STATES] = at;
}

int p3_cvode(const problem *p, const double *start, const double *scale, double rtol, int n_out, const double *t_out,
             double *out, long *count) {
    return by_cvode(p, start, scale, rtol, n_out, t_out, out, count);
}
#else
#include "solve.h"

int p3_solve(const problem *p, const double *start, const double *side, const double *scale, double first_step,
             double rtol, int n_out, const double *t_out, double *out, long *count) {
    return solve(p, start, side, scale, first_step, rtol, n_out, t_out, out, count);
}
#endif
