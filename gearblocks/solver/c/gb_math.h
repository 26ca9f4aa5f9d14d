/* Sine, cosine and arc tangent for generated code: branch-free, so that a loop over lanes becomes vector code, and
 * with the same bits in vector and scalar code (contraction must be off).
 *
 * Error below 1 ulp for |x| <= 1e6 and below 2 ulp for |x| <= 1e9. Beyond, the result is that of an argument within
 * one ulp of x, up to 1e13. Infinite and NaN arguments give NaN.
 * Method: reduction with pi/2 in parts (Cody and Waite 1980), Chebyshev interpolants.
 *
 * Knows nothing of models. */
#ifndef GB_MATH_H
#define GB_MATH_H

#include "gb_inline.h"

#include <math.h>

/* 1 from 0 on, else 0. */
GB_INLINE double gb_unit_step(double x) {
    return x >= 0.0 ? 1.0 : 0.0;
}

/* x where m is 1, else 0: also where x is infinite or NaN, which 0 times x would be. */
GB_INLINE double gb_where(double m, double x) {
    return m > 0.5 ? x : 0.0;
}

/* x - floor(x), below 1 even where a tiny negative x would round up to it. */
GB_INLINE double gb_fraction(double x) {
    const double rest = x - floor(x);
    return rest < 1.0 ? rest : 0.0;
}

/* x = n pi/2 + hi + lo with |hi| <= pi/4 in round-to-nearest; quadrant in {-2, -1, 0, 1, 2}, n modulo 4. */
typedef struct gb_reduced {
    double hi, lo, quadrant;
} gb_reduced;

/* The first three parts of pi/2 have 22 bits, so that their products with n < 2^31 are exact. */
GB_INLINE gb_reduced gb_reduce(double x) {
    const double shift = 6755399441055744.0; /* 1.5 2^52: adding it rounds to an integer */
    const double n = (x * 0x1.45f306dc9c883p-1 + shift) - shift;
    const double cycles = (n * 0.25 + shift) - shift;
    const double a = (x - n * 0x1.921fbp+0) - n * 0x1.5110bp-22;
    const double c = n * 0x1.1846980000000p-44;
    gb_reduced r;
    r.quadrant = n - 4.0 * cycles;
    const double near = a - c, rest = ((a - near) - c) - n * 0x1.3198a2e037073p-69;
    r.hi = near + rest;
    r.lo = (near - r.hi) + rest;
    return r;
}

/* sin(hi + lo) and cos(hi + lo) for |hi| <= pi/4: Chebyshev interpolants, error below 2e-17. */
GB_INLINE double gb_sin_core(double hi, double lo) {
    const double z = hi * hi;
    const double z2 = z * z;
    const double low = -0x1.5555555555555p-3 + z * 0x1.1111111110bb1p-7;
    const double mid = -0x1.a01a019e8357dp-13 + z * 0x1.71de37961e4c6p-19;
    const double top = -0x1.ae600a926c89ap-26 + z * 0x1.5e0af186af739p-33;
    const double p = low + z2 * (mid + z2 * top);
    return hi + (z * hi * p + lo * (1.0 - 0.5 * z));
}

GB_INLINE double gb_cos_core(double hi, double lo) {
    const double z = hi * hi;
    const double z2 = z * z;
    const double low = 0x1.5555555555555p-5 + z * -0x1.6c16c16c16966p-10;
    const double mid = 0x1.a01a019f4e867p-16 + z * -0x1.27e4fa17a41b4p-22;
    const double top = 0x1.1eeb68b109173p-29 + z * -0x1.907d7aebd5e3dp-37;
    const double p = low + z2 * (mid + z2 * top);
    const double half = 0.5 * z;
    const double lead = 1.0 - half;
    return lead + (((1.0 - lead) - half) + (z2 * p - hi * lo));
}

GB_INLINE double gb_sin(double x) {
    const gb_reduced r = gb_reduce(x);
    const double s = gb_sin_core(r.hi, r.lo);
    const double c = gb_cos_core(r.hi, r.lo);
    const double odd = r.quadrant < 0.0 ? -c : c;
    const double even = r.quadrant == 0.0 ? s : -s;
    return r.quadrant * r.quadrant == 1.0 ? odd : even;
}

GB_INLINE double gb_cos(double x) {
    const gb_reduced r = gb_reduce(x);
    const double s = gb_sin_core(r.hi, r.lo);
    const double c = gb_cos_core(r.hi, r.lo);
    const double odd = r.quadrant < 0.0 ? s : -s;
    const double even = r.quadrant == 0.0 ? c : -c;
    return r.quadrant * r.quadrant == 1.0 ? odd : even;
}

/* Error below 2 ulp. atan a = base + atan t with t = a, (a - 1)/(a + 1) or -1/a and |t| <= tan(pi/8). */
GB_INLINE double gb_atan(double x) {
    const double a = x < 0.0 ? -x : x;
    const int above = a > 0x1.a827999fcef32p-2, far = a > 0x1.3504f333f9de6p+1;
    const double t = (far ? -1.0 : (above ? a - 1.0 : a)) / (far ? a : (above ? a + 1.0 : 1.0));
    const double base = far ? 0x1.921fb54442d18p+0 : (above ? 0x1.921fb54442d18p-1 : 0.0);
    const double rest = far ? 0x1.1a62633145c07p-54 : (above ? 0x1.1a62633145c07p-55 : 0.0);
    const double z = t * t, z2 = z * z, z4 = z2 * z2;
    const double c0 = -0x1.5555555555555p-2 + z * 0x1.9999999999953p-3;
    const double c2 = -0x1.249249248d7eep-3 + z * 0x1.c71c71c304b64p-4;
    const double c4 = -0x1.745d165df3ee7p-4 + z * 0x1.3b1392d9e64b0p-4;
    const double c6 = -0x1.110e880a643d8p-4 + z * 0x1.e19a13b800ab6p-5;
    const double c8 = -0x1.ac7a937cce153p-5 + z * 0x1.74ddd3c6187b4p-5;
    const double c10 = -0x1.1b33b8784aa69p-5 + z * 0x1.0ad368c98424cp-6;
    const double p = (c0 + z2 * c2) + z4 * ((c4 + z2 * c6) + z4 * (c8 + z2 * c10));
    const double r = base + (t + (t * z * p + rest));
    return x < 0.0 ? -r : r;
}

/* x |x|^(n - 1), n > 0, for order 0; its integral for order -1, its derivatives above (0 where they have no bound). */
static inline double gb_signed_power(double x, double n, int order) {
    const double size = fabs(x);
    if (order < 0)
        return pow(size, n + 1.0) / (n + 1.0);
    if (size == 0.0)
        return order == 1 && n == 1.0 ? 1.0 : 0.0;
    if (order == 0)
        return x * pow(size, n - 1.0);
    if (order == 1)
        return n * pow(size, n - 1.0);
    return n * (n - 1.0) * x * pow(size, n - 3.0);
}

/* The angle a with tan(a) - a = y; NaN for y < 0. Newton from above: the function is convex. */
static inline double gb_inverse_involute(double y) {
    if (!(y > 0.0)) {
        return y == 0.0 ? 0.0 : nan("");
    }
    double a = fmin(cbrt(3.0 * y), 1.5);
    for (int i = 0; i < 40; i++) {
        const double t = tan(a), step = (t - a - y) / (t * t);
        a -= step;
        if (fabs(step) <= 1e-16) {
            break;
        }
    }
    return a;
}

/* a = chi v0 of a force k x^n (1 + chi x') with restitution e: a (1 + e) = ln((1 + a)/(1 - e a)); NaN unless 0 < e
 * <= 1. */
static inline double gb_restitution_damping(double e) {
    if (!(e > 0.0 && e <= 1.0)) {
        return nan("");
    }
    if (1.0 - e < 1e-4) {
        return 1.5 * (1.0 - e * e) / (1.0 + e * e * e);
    }
    double low = 0.0, high = 1.0; /* of u = e a */
    for (int i = 0; i < 200; i++) {
        const double u = 0.5 * (low + high);
        if (u == low || u == high) {
            break;
        }
        if (u * (1.0 + e) / e - log1p(u / e) + log1p(-u) > 0.0) {
            low = u;
        } else {
            high = u;
        }
    }
    return low / e;
}

/* Whether outputs first .. last of a batch, counted from its first one, are one output of one or several of its `count`
 * instances, which stand side by side. */
static inline int gb_is_one_output(int first, int last, int count) {
    return first >= 0 && first / count == last / count;
}

#endif
