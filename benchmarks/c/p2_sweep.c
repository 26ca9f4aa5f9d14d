/* P2 for 32 frequencies at once, by hand: classical Runge-Kutta method in vectors as wide as a register, two chains of
 * 16 lanes each, excitation tabulated over a period, sides as a clipped deflection. out: last deflection and rate. */
#include <math.h>
#include <stdlib.h>

#if defined(__AVX512F__)
enum { WIDTH = 8 };
#elif defined(__AVX__)
enum { WIDTH = 4 };
#else
enum { WIDTH = 2 };
#endif
enum { LANES = 32, VECTORS = LANES / WIDTH, ABREAST = 2 };

typedef double vec __attribute__((vector_size(WIDTH * sizeof(double))));
typedef long long bits __attribute__((vector_size(WIDTH * sizeof(double))));

static inline __attribute__((always_inline)) vec select_of(bits which, vec one, vec other) {
    return (vec)(((bits)one & which) | ((bits)other & ~which));
}

static inline __attribute__((always_inline)) vec rate(vec x, vec v, vec k, vec f, double damping) {
    const vec one = (vec){0.0} + 1.0;
    const vec above = x - one, below = x + one, none = (vec){0.0};
    const vec g = select_of(x > one, above, select_of(x < -one, below, none));
    return f - damping * v - k * g;
}

void p2_sweep(const double *w, double zeta, double eps, double load, double swing, double x0, long periods,
              long per_period, double *out) {
    vec x[VECTORS], v[VECTORS], h[VECTORS];
    const size_t instants = 2 * (size_t)per_period + 1;
    char *memory = malloc(2 * instants * VECTORS * sizeof(vec) + sizeof(vec));
    vec *k = (vec *)(memory + sizeof(vec) - (size_t)memory % sizeof(vec)), *f = k + instants * VECTORS;
    for (int l = 0; l < LANES; l++) {
        const double step = 2.0 * 3.14159265358979323846 / w[l] / (double)per_period;
        x[l / WIDTH][l % WIDTH] = x0;
        v[l / WIDTH][l % WIDTH] = 0.0;
        h[l / WIDTH][l % WIDTH] = step;
        for (size_t i = 0; i < instants; i++) {
            const double wave = cos(w[l] * (double)i * 0.5 * step);
            k[i * VECTORS + (size_t)(l / WIDTH)][l % WIDTH] = 1.0 + eps * wave;
            f[i * VECTORS + (size_t)(l / WIDTH)][l % WIDTH] = load + swing * w[l] * w[l] * wave;
        }
    }
    const double damping = 2.0 * zeta;
    for (long period = 0; period < periods; period++) {
        for (long s = 0; s < per_period; s++) {
            const vec *k0 = k + 2 * s * VECTORS, *k1 = k0 + VECTORS, *k2 = k1 + VECTORS;
            const vec *f0 = f + 2 * s * VECTORS, *f1 = f0 + VECTORS, *f2 = f1 + VECTORS;
            for (int i = 0; i < VECTORS; i += ABREAST) {
                vec b1[ABREAST], b2[ABREAST], b3[ABREAST], v2[ABREAST], v3[ABREAST], v4[ABREAST], z[ABREAST];
                for (int a = 0; a < ABREAST; a++) {
                    const vec half = 0.5 * h[i + a];
                    b1[a] = rate(x[i + a], v[i + a], k0[i + a], f0[i + a], damping);
                    v2[a] = v[i + a] + half * b1[a];
                    z[a] = x[i + a] + half * v[i + a];
                }
                for (int a = 0; a < ABREAST; a++) {
                    const vec half = 0.5 * h[i + a];
                    b2[a] = rate(z[a], v2[a], k1[i + a], f1[i + a], damping);
                    v3[a] = v[i + a] + half * b2[a];
                    z[a] = x[i + a] + half * v2[a];
                }
                for (int a = 0; a < ABREAST; a++) {
                    b3[a] = rate(z[a], v3[a], k1[i + a], f1[i + a], damping);
                    v4[a] = v[i + a] + h[i + a] * b3[a];
                    z[a] = x[i + a] + h[i + a] * v3[a];
                }
                for (int a = 0; a < ABREAST; a++) {
                    const vec sixth = h[i + a] * (1.0 / 6.0), b4 = rate(z[a], v4[a], k2[i + a], f2[i + a], damping);
                    x[i + a] += sixth * (v[i + a] + 2.0 * (v2[a] + v3[a]) + v4[a]);
                    v[i + a] += sixth * (b1[a] + 2.0 * (b2[a] + b3[a]) + b4);
                }
            }
        }
    }
    for (int l = 0; l < LANES; l++) {
        out[2 * l] = x[l / WIDTH][l % WIDTH];
        out[2 * l + 1] = v[l / WIDTH][l % WIDTH];
    }
    free(memory);
}
