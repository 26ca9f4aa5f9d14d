/* Error control of the ledger:  q_i' = P_i(t, y), powers of losses and supplies that no law reads. With sum_i |error of
 * q_i| as the error of a step and sum_i |change of q_i| as its exchange, error <= rtol (exchange + SHARE h / (t -
 * t_start + h) (turnover + stored)) + h noise : relative to what the step exchanges, and where that passes zero to what
 * a step of its length exchanges on average, so that all steps together stay within a few rtol of the turnover. A
 * quadrature is more exact than the embedded estimate e_i of the states: with r = sum |e_i| / exchange its error is C
 * r^q of the exchange (C and q from P = sin wt); an implicit step takes r from differences of P at the nodes of its
 * quadrature. Looked at where the states do not set the step, and now and then elsewhere. Assumed: the stages of the
 * step just computed, those of the quadratures too. Knows nothing of laws: the noise is the answer of the powers to the
 * last bits of the states. */
#ifndef GB_LEDGER_H
#define GB_LEDGER_H

#include "gb_vector.h"

/* Where the energies begin among the quadratures, and where they end. */
static inline int gb_first_energy(const gb_model *model) {
    return model->n_padded + model->n_angles;
}

static inline int gb_end_energy(const gb_model *model) {
    return model->n_padded + model->n_quadratures;
}

/* What a step from y0 to y exchanges: the blocks of the energies without the angles in the first one; what fills up the
 * last one is 0. */
GB_INLINE double gb_exchange(const gb_sim *sim, const double *y) {
    static const double kept[2 * GB_PAD] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1};
    const int from = gb_first_energy(sim->model), end = gb_end_energy(sim->model), angles = from % GB_PAD;
    const double *keep = kept + GB_PAD - angles;
    gb_half sum = {0.0};
    for (int b = from - angles; b < end; b += GB_PAD, keep = kept + GB_PAD) {
        for (int l = 0; l < GB_PAD; l += GB_PAD / 2) {
            gb_half change = *gb_half_at(y + b + l) - *gb_half_at(sim->y0 + b + l);
            gb_half_abs(&change);
            sum += *gb_half_at(keep + l) * change;
        }
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* log2 of the error of the ledger in the step of size h just computed, in units of its tolerance. */
double gb_ledger_look(gb_sim *sim, double h);

/* The same where somebody looks, else -100; log_error: that of the states, which set the step unless it is below
 * 2^-14. */
static inline double gb_ledger_log_error(gb_sim *sim, double h, double log_error) {
    const gb_head *head = sim->head;
    const int alone = log_error <= (sim->model->prescribed_motion ? 0.0 : -14.0);
    const size_t slot = (size_t)(head->events.mode_hash % GB_MEMORY);
    const int due = head->counts.steps >= head->ledger.look_at || h > head->ledger.h_known[slot] ||
                    head->events.mode_hash != head->ledger.modes[slot];
    return alone || (due && !head->choice.large_step) ? gb_ledger_look(sim, h) : -100.0;
}

/* After the front was moved back to theta inside the step: the integrals once more, by points of Gauss along the
 * polynomials of the states, where those of the polynomials of the step are off by 2 tolerances of what is kept: the
 * exchange beyond an event counts for nothing, laws do not hold there. Assumed: z is the end of the step. */
int gb_ledger_cut(gb_sim *sim, double theta);

/* What the step exchanged counts as turnover. */
static inline void gb_ledger_take(gb_sim *sim) {
    const double exchanged = gb_exchange(sim, sim->y);
    sim->head->ledger.turnover_segment = exchanged;
    sim->head->ledger.turnover += exchanged;
}

#endif
