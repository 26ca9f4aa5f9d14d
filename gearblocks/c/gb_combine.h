/* Weighted sums over whole blocks of padded vectors: the inner loops of the solver. */
#ifndef GB_COMBINE_H
#define GB_COMBINE_H

#include "gb_internal.h"

static inline const gb_block *gb_block_at(const double *x) {
    return (const gb_block *)(const void *)x;
}

#define GB_INLINE static inline __attribute__((always_inline))

/* out = y + h sum_j w_j k_j in the entries [from, to), both multiples of GB_PAD. The last entry of w is the latest
 * stage, which everything waits for: it enters last and through one product. */
GB_INLINE void gb_combine(const gb_weights *w, const double *k, int stride, int from, int to, const double *y, double h,
                          double *out) {
    const int last = w->count - 1;
    const double final = h * w->value[last];
    for (int b = from; b < to; b += GB_PAD) {
        gb_block sum = {0.0};
        for (int j = 0; j < last; j++) {
            sum += w->value[j] * *gb_block_at(k + (size_t)w->index[j] * (size_t)stride + b);
        }
        *(gb_block *)(void *)(out + b) =
            (*gb_block_at(y + b) + h * sum) + final * *gb_block_at(k + (size_t)w->index[last] * (size_t)stride + b);
    }
}

/* out = x, count being a multiple of GB_PAD. */
static inline void gb_copy(double *out, const double *x, int count) {
    for (int b = 0; b < count; b += GB_PAD) {
        *(gb_block *)(void *)(out + b) = *gb_block_at(x + b);
    }
}

/* Zero when all entries of x are finite, else NaN. count must be a multiple of GB_PAD. */
static inline double gb_taint(const double *restrict x, int count) {
    gb_block sum = {0.0};
    for (int b = 0; b < count; b += GB_PAD) {
        sum += *gb_block_at(x + b) - *gb_block_at(x + b);
    }
    return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

#endif
