#include "gb_ledger.h"
#include "gb_dense_output.h"
#include "gb_error_control.h"
#include "gb_rates.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

/* Tolerance below which rounding would decide. */
static const double LEAST = 1e-12;

/* Part of the mean exchange of a step of this length that may stand for its own. */
static const double SHARE = 0.3;

/* Part of the turnover and of what is stored that counts in every step: a jump that no switch announces costs no more.
 * Of many steps, that of the mean: all of them together count the turnover once. */
static const double LITTLE = 1e-3;

/* Kept from the tolerance at the end of a step, as log2. */
static const double SAFETY = 2.0;

/* Steps between two looks where the states set the step; log2 of an error that is looked at again at once. */
enum { BETWEEN = 64, NEAR = -1 };

/* An integral of a cut step that is right by so much, as log2, is not looked at in the next ones in its modes. */
static const double NO_CUT = 4.0;
enum { MOST_CUTS = 32 };

/* By how much an estimate may fall from one step to the next, as log2, and from where on that is looked at: far below
 * rounding decides. */
static const double FALL = 2.0, FAR = -12.0;

/* Points of Gauss and Legendre in [0, 1]. */
typedef struct gauss_point {
    double at, weight;
} gauss_point;

static const gauss_point GAUSS_3[] = {
    {0.1127016653792583, 0.2777777777777778},
    {0.5, 0.4444444444444444},
    {0.8872983346207417, 0.2777777777777778},
};
static const gauss_point GAUSS_5[] = {
    {0.0469100770306680, 0.1184634425280945}, {0.2307653449471585, 0.2393143352496833}, {0.5, 0.2844444444444444},
    {0.7692346550528415, 0.2393143352496833}, {0.9530899229693320, 0.1184634425280945},
};

/* sum_i |sum_j e_j P_i,j| over the energies: their embedded error, without the factor h. */
static double embedded_error(const gb_sim *sim, const gb_weights *e) {
    const gb_model *model = sim->model;
    const int first = gb_first_energy(model), end = gb_end_energy(model);
    double sum = 0.0;
    for (int b = first - first % GB_PAD; b < end; b += GB_PAD) {
        double error[GB_PAD];
        gb_combine(e, sim->k + b, model->n_total, 0, GB_PAD, sim->zero, 1.0, error);
        for (int l = b < first ? first - b : 0; l < GB_PAD && b + l < end; l++) {
            sum += fabs(error[l]);
        }
    }
    return sum;
}

/* The differences of second and third order of the powers at the four points of an implicit step, (wh)^2/60 and
 * (wh)^3/450 for P = sin wt. */
static void bends(const gb_sim *sim, double *second, double *third) {
    const gb_model *model = sim->model;
    const size_t total = (size_t)model->n_total;
    const double *first = sim->k1, *end = sim->k + (size_t)sim->method->stages * total, *one = end + total,
                 *two = one + total, root = sqrt(5.0);
    *second = *third = 0.0;
    for (int i = gb_first_energy(model); i < gb_end_energy(model); i++) {
        *second += fabs((first[i] - one[i]) + (end[i] - two[i])) / 12.0;
        *third += fabs((end[i] - first[i]) - root * (two[i] - one[i])) / 15.0;
    }
}

/* The powers at theta of the step just computed, from its polynomial. */
static int powers_at(gb_sim *sim, double theta, double h, double *rate) {
    const double from = sim->head->front.t0;
    gb_dense_states(sim, theta, sim->z2);
    const int code = gb_time_terms_at(sim, from + theta * h);
    if (code == GB_DONE) {
        gb_rates(sim, 1, &sim->instant, 0, sim->z2, rate);
        sim->head->counts.rhs_calls++;
    }
    return code;
}

/* The difference of fourth order in the middle of an implicit step, (wh)^4/1920 for P = sin wt: what a cubic through
 * the four points misses there. HUGE_VAL where it cannot be had. */
static double bend_in_the_middle(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const size_t total = (size_t)model->n_total;
    const double *first = sim->k1, *end = sim->k + (size_t)sim->method->stages * total, *one = end + total,
                 *two = one + total;
    double *middle = sim->k + (size_t)(GB_STAGES - 1) * total, sum = 0.0;
    sim->head->front.t0 = sim->head->front.t1;
    sim->head->front.h = h;
    gb_dense_hermite(sim);
    const int code = powers_at(sim, 0.5, h, middle);
    sim->head->front.h = 0.0;
    sim->head->front.have_dense = 0;
    for (int i = gb_first_energy(model); i < gb_end_energy(model); i++) {
        sum += fabs(middle[i] - 0.125 * (5.0 * (one[i] + two[i]) - (first[i] + end[i])));
    }
    return code == GB_DONE ? sum : HUGE_VAL;
}

/* How far the powers at y move with the states by the bits in z2, of alternating sign. */
static double answer_to_bits(gb_sim *sim, int lane, const double *y, const double *powers) {
    const gb_model *model = sim->model;
    double *rate = sim->k + (size_t)(GB_STAGES - 1) * (size_t)model->n_total, sum = 0.0;
    for (int i = 0; i < model->n_padded; i++) {
        sim->z2[i] = y[i] + (i % 2 == 0 ? sim->z2[i] : -sim->z2[i]);
    }
    gb_rates(sim, 1, &sim->lanes, lane, sim->z2, rate);
    sim->head->counts.rhs_calls++;
    for (int i = gb_first_energy(model); i < gb_end_energy(model); i++) {
        sum += fabs(rate[i] - powers[i]);
    }
    return sum;
}

/* No state moves in the step by more than the noise of its rate, nor beyond its scale where it has one: a trial that
 * explodes takes its noise along. */
static int is_noise(const gb_sim *sim, double h) {
    int is = 1;
    for (int i = 0; i < sim->model->n; i++) {
        const double scale = gb_max(sim->control.largest[i], sim->control.natural_scale[i]);
        const double noise = h * sim->control.noise[i];
        is &= fabs(sim->z[i] - sim->y0[i]) <= (scale > 0.0 ? gb_min(noise, scale) : noise);
    }
    return is;
}

/* How far rounding moves the powers: their answer to a change of the states in their last bits, or by what the noise of
 * their rates makes of them in a step. Where states have no scale and move by that noise alone: returns what it makes
 * of the powers at the end of the step. */
static double measure_noise(gb_sim *sim, double h) {
    const int n = sim->model->n_padded, end = sim->method->stages;
    for (int i = 0; i < n; i++) {
        sim->z2[i] = gb_max(2.0 * DBL_EPSILON * sim->control.largest[i], h * sim->control.noise[i]);
    }
    sim->head->ledger.noise = gb_max(answer_to_bits(sim, 0, sim->y0, sim->k1), sim->head->ledger.noise);
    if (!sim->head->control.unscaled || !is_noise(sim, h)) {
        return 0.0;
    }
    for (int i = 0; i < n; i++) {
        sim->z2[i] = h * sim->control.noise[i];
    }
    return answer_to_bits(sim, end, sim->z, sim->k + (size_t)end * (size_t)sim->model->n_total);
}

/* The largest energy that the train stored at a look, at the front: where a step ends that reaches beyond an event, the
 * laws hold no more. */
static void look_at_stored(gb_sim *sim) {
    const gb_model *model = sim->model;
    double stored = 0.0;
    model->energies(sim->par, sim->mode, sim->lanes.time_terms, sim->y0, sim->scratch.energies);
    for (int i = 0; i < model->n_energies; i++) {
        stored += fabs(sim->scratch.energies[i]);
    }
    sim->head->ledger.stored = gb_max(sim->head->ledger.stored, stored);
}

/* The energy against which the errors of a step of size h that ends `so_far` after the start count: its exchange and
 * parts of what was exchanged so far. */
static double yardstick(const gb_sim *sim, double exchanged, double h, double so_far) {
    const struct gb_ledger *ledger = &sim->head->ledger;
    /* corners that are not located are jumps that no switch announces */
    const double mean = sim->head->options.locate ? 1.0 / (double)(sim->head->counts.steps + 1) : LITTLE;
    const double little = gb_min(LITTLE, mean);
    return exchanged + (SHARE * h / so_far + little) * (ledger->turnover + ledger->stored);
}

/* log2 of the error at the end of a step and inside it, over the yardstick. */
typedef struct gb_errors {
    double end, inside;
} gb_errors;

/* From the embedded estimates. An interpolant of the order of the method is as right as its estimate; that of a single
 * pair is an order below. */
static gb_errors explicit_errors(const gb_method *method, double one, double two) {
    if (method->n_errors == 1) {
        const double log = gb_rough_log2(one + 1e-30);
        return (gb_errors){1.2 * log + 0.7, log + 3.0};
    }
    const double log = gb_rough_log2(one * one / sqrt(one * one + 0.01 * two * two) + 1e-30);
    return (gb_errors){1.125 * log - 2.6, log - 1.6};
}

/* From the differences of the powers; either passes zero by chance. Inside, an eighth of them is off: their square
 * holds for powers as large as the yardstick alone. */
static gb_errors implicit_errors(double second, double third) {
    const double two = gb_rough_log2(second + 1e-30), three = gb_rough_log2(third + 1e-30);
    return (gb_errors){gb_max(3.0 * two, 2.0 * three) - 3.0, gb_max(two, three) - 3.0};
}

/* At the end of an implicit step where its middle tells more: a power that is a polynomial up to the third degree has
 * no error at all, however much it bends. */
static double implicit_error_by_middle(double fourth) {
    return 1.5 * gb_rough_log2(fourth + 1e-30) - 1.0;
}

/* What tells the errors of a step: two embedded estimates of an explicit one, differences of powers of an implicit one.
 */
static void told_by_stages(const gb_sim *sim, double *one, double *two) {
    const gb_method *method = sim->method;
    if (method->gamma > 0.0) {
        bends(sim, one, two);
    } else {
        *one = embedded_error(sim, &method->e[0]);
        *two = method->n_errors > 1 ? embedded_error(sim, &method->e[1]) : 0.0;
    }
}

/* The errors by these, over the yardstick. */
static gb_errors errors_by(const gb_method *method, double one, double two) {
    return method->gamma > 0.0 ? implicit_errors(one, two) : explicit_errors(method, one, two);
}

/* log2 of the error in units of its tolerance, at the cost that it takes to find out. */
static double estimate(gb_sim *sim, double h) {
    gb_head *head = sim->head;
    const int implicit = sim->method->gamma > 0.0;
    const double rtol = gb_max(head->options.rtol, LEAST), exchanged = gb_exchange(sim, sim->z);
    double one, two, noise = 0.0;
    told_by_stages(sim, &one, &two);
    for (int more = 0;; more++) {
        const double size = yardstick(sim, exchanged, h, head->front.t1 - head->front.t_start + h) / h;
        if (!(size > 0.0 && one + two > 1e-30 * size)) {
            return -100.0;
        }
        const double tolerance = gb_rough_log2(rtol + gb_max(head->ledger.noise, noise) / size);
        const gb_errors found = errors_by(sim->method, one / size, two / size);
        if (found.end + SAFETY <= tolerance) {
            return found.end + SAFETY - tolerance;
        }
        if (more == 1) {
            const double by_middle = implicit ? implicit_error_by_middle(bend_in_the_middle(sim, h) / size) : HUGE_VAL;
            return gb_min(found.end, by_middle) + SAFETY - tolerance;
        }
        look_at_stored(sim);
        noise = measure_noise(sim, h);
    }
}

/* An estimate passes zero by chance where a power turns: it falls by no more than FALL from one step to the next
 * in the same modes, beside what the step size explains. */
static double against_chance(const gb_sim *sim, double h, double found) {
    const struct gb_ledger *ledger = &sim->head->ledger;
    const int follows = sim->head->counts.steps == ledger->found_at + 1 && ledger->h_found > 0.0;
    if (!follows || sim->head->events.mode_hash != ledger->found_modes || ledger->found < FAR) {
        return found;
    }
    const double power = (double)(sim->method->order + 1);
    return gb_max(found, ledger->found + power * gb_rough_log2(h / ledger->h_found) - FALL);
}

double gb_ledger_look(gb_sim *sim, double h) {
    gb_head *head = sim->head;
    const uint64_t modes = head->events.mode_hash;
    const size_t slot = (size_t)(modes % GB_MEMORY);
    const double found = against_chance(sim, h, estimate(sim, h));
    const double known = head->ledger.modes[slot] == modes ? 0.8 * head->ledger.h_known[slot] : 0.0;
    head->ledger.look_at = head->counts.steps + (found > NEAR ? 1 : BETWEEN);
    head->ledger.modes[slot] = modes;
    head->ledger.h_known[slot] = found > NEAR ? h : gb_max(2.0 * h, known);
    if (found <= 0.0) {
        head->ledger.found = found;
        head->ledger.h_found = h;
        head->ledger.found_at = head->counts.steps;
        head->ledger.found_modes = modes;
    }
    return found;
}

/* The integrals from y0 to theta, by points of Gauss along the polynomials of the states. */
static int integrate(gb_sim *sim, double theta) {
    const gb_model *model = sim->model;
    const double h = sim->head->front.h;
    const int count = sim->method->order > 5 ? 5 : 3;
    const gauss_point *points = count == 5 ? GAUSS_5 : GAUSS_3;
    for (int i = gb_first_energy(model); i < gb_end_energy(model); i++) {
        sim->y[i] = sim->y0[i];
    }
    int code = GB_DONE;
    for (int j = 0; j < count && code == GB_DONE; j++) {
        code = powers_at(sim, points[j].at * theta, h, sim->z);
        for (int i = gb_first_energy(model); i < gb_end_energy(model); i++) {
            sim->y[i] += theta * h * points[j].weight * sim->z[i];
        }
    }
    return code;
}

int gb_ledger_cut(gb_sim *sim, double theta) {
    const struct gb_front *front = &sim->head->front;
    struct gb_ledger *ledger = &sim->head->ledger;
    const double h = front->h, rtol = gb_max(sim->head->options.rtol, LEAST);
    const uint64_t modes = sim->head->events.mode_hash;
    double one, two;
    if (!(front->t1 > front->t0) || gb_is_patient(&ledger->cuts, modes, sim->head->counts.events)) {
        return GB_DONE;
    }
    const double kept = yardstick(sim, gb_exchange(sim, sim->y), theta * h, front->t1 - front->t_start) / h;
    told_by_stages(sim, &one, &two);
    if (!(kept > 0.0 && one + two > 1e-30 * kept)) {
        return GB_DONE;
    }
    const double whole = yardstick(sim, gb_exchange(sim, sim->z), h, front->t0 + h - front->t_start) / h;
    const double inside = errors_by(sim->method, one / whole, two / whole).inside + gb_rough_log2(whole / kept);
    const double limit = gb_rough_log2(rtol + ledger->noise / kept) + 1.0;
    gb_looked(&ledger->cuts, modes, sim->head->counts.events, inside < limit - NO_CUT ? MOST_CUTS : 0);
    return inside > limit ? integrate(sim, theta) : GB_DONE;
}
