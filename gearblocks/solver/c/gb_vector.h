/* Vectors padded to blocks of GB_PAD:  out = y + h sum_j w_j k_j,  copies, and a test for NaN and infinity. The inner
 * loops of every step: the same operations in the same order whatever the width of the machine's registers.
 * Knows nothing of methods, steps and models. */
#ifndef GB_VECTOR_H
#define GB_VECTOR_H

#include "gb_inline.h"
#include "gb_internal.h"

static inline double gb_max(double a, double b) {
    return a > b ? a : b;
}

static inline double gb_min(double a, double b) {
    return a < b ? a : b;
}

static inline const gb_block *gb_block_at(const double *x) {
    return (const gb_block *)(const void *)x;
}

/* Half a block: what compilers compare and mask as one on most machines. The operations are exact, so that halves of
 * any width give the same bits. */
typedef double gb_half __attribute__((vector_size(GB_PAD / 2 * sizeof(double)), aligned(sizeof(double)), may_alias));
typedef long long gb_bits __attribute__((vector_size(GB_PAD / 2 * sizeof(double)), aligned(sizeof(double)), may_alias));

static inline const gb_half *gb_half_at(const double *x) {
    return (const gb_half *)(const void *)x;
}

GB_INLINE void gb_half_abs(gb_half *x) {
    *x = (gb_half)((gb_bits)*x & 0x7fffffffffffffffLL);
}

/* most = x > most ? x : most in each entry. */
GB_INLINE void gb_half_max(gb_half *most, const gb_half *x) {
    const gb_bits above = *x > *most;
    *most = (gb_half)(((gb_bits)*x & above) | ((gb_bits)*most & ~above));
}

GB_INLINE double gb_half_largest(const gb_half *x) {
    return gb_max(gb_max((*x)[0], (*x)[1]), gb_max((*x)[2], (*x)[3]));
}

GB_INLINE double gb_block_sum(const gb_block *x) {
    return (((*x)[0] + (*x)[1]) + ((*x)[2] + (*x)[3])) + (((*x)[4] + (*x)[5]) + ((*x)[6] + (*x)[7]));
}

/* out = (y + h sum) + final latest, in half a block. */
GB_INLINE void gb_finish(const gb_half *sum, const double *y, double h, double final, const double *latest,
                         double *out) {
    *(gb_half *)(void *)out = (*gb_half_at(y) + h * *sum) + final * *gb_half_at(latest);
}

/* out = y + h sum_j w_j k_j in the entries [from, to), both multiples of GB_PAD. The last entry of w is the latest
 * stage, which everything waits for: it enters last and through one product. Two blocks at once where there are as
 * many: a weight and where its stage lies are read once. */
GB_INLINE void gb_combine(const gb_weights *w, const double *k, int stride, int from, int to, const double *y, double h,
                          double *out) {
    const int last = w->count - 1;
    const double final = h * w->value[last];
    const double *latest = k + (size_t)w->index[last] * (size_t)stride;
    int b = from;
    for (; b + GB_PAD < to; b += 2 * GB_PAD) {
        const gb_half none = {0.0};
        gb_half one = none, two = none, three = none, four = none;
        for (int j = 0; j < last; j++) {
            const double *at = k + (size_t)w->index[j] * (size_t)stride + b, weight = w->value[j];
            one += weight * *gb_half_at(at);
            two += weight * *gb_half_at(at + GB_PAD / 2);
            three += weight * *gb_half_at(at + GB_PAD);
            four += weight * *gb_half_at(at + GB_PAD + GB_PAD / 2);
        }
        gb_finish(&one, y + b, h, final, latest + b, out + b);
        gb_finish(&two, y + b + GB_PAD / 2, h, final, latest + b + GB_PAD / 2, out + b + GB_PAD / 2);
        gb_finish(&three, y + b + GB_PAD, h, final, latest + b + GB_PAD, out + b + GB_PAD);
        gb_finish(&four, y + b + GB_PAD + GB_PAD / 2, h, final, latest + b + GB_PAD + GB_PAD / 2,
                  out + b + GB_PAD + GB_PAD / 2);
    }
    if (b < to) {
        gb_block sum = {0.0};
        for (int j = 0; j < last; j++) {
            sum += w->value[j] * *gb_block_at(k + (size_t)w->index[j] * (size_t)stride + b);
        }
        *(gb_block *)(void *)(out + b) = (*gb_block_at(y + b) + h * sum) + final * *gb_block_at(latest + b);
    }
}

/* out[m] = y[m] + h[m] sum_j w[m][j] k_j for `count` (a constant) sums over the same stages j < stages at once: what
 * memory holds is read once. y[m] NULL: nothing is added. */
GB_INLINE void gb_combine_all(int count, const double (*w)[GB_STAGES], int stages, const double *k, int stride, int to,
                              const double *const *y, const double *h, double *const *out) {
    for (int b = 0; b < to; b += GB_PAD) {
        gb_block sum[GB_ROWS];
        for (int m = 0; m < count; m++) {
            sum[m] = w[m][0] * *gb_block_at(k + b);
        }
        for (int j = 1; j < stages; j++) {
            const gb_block one = *gb_block_at(k + (size_t)j * (size_t)stride + b);
            for (int m = 0; m < count; m++) {
                sum[m] += w[m][j] * one;
            }
        }
        for (int m = 0; m < count; m++) {
            gb_block all = h[m] * sum[m];
            if (y[m]) {
                all += *gb_block_at(y[m] + b);
            }
            *(gb_block *)(void *)(out[m] + b) = all;
        }
    }
}

/* out = x, count being a multiple of GB_PAD. */
static inline void gb_copy(double *out, const double *x, int count) {
    for (int b = 0; b < count; b += GB_PAD) {
        *(gb_block *)(void *)(out + b) = *gb_block_at(x + b);
    }
}

/* Zero when all entries of x are finite, else NaN: in whatever order the products are added. count must be a multiple
 * of GB_PAD. */
static inline double gb_taint(const double *restrict x, int count) {
    gb_half one = {0.0}, other = {0.0};
    for (int b = 0; b < count; b += GB_PAD) {
        one += 0.0 * *gb_half_at(x + b);
        other += 0.0 * *gb_half_at(x + b + GB_PAD / 2);
    }
    one += other;
    return (one[0] + one[1]) + (one[2] + one[3]);
}

#endif
