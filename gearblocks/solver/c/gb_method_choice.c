#include "gb_method_choice.h"
#include "gb_evaluate.h"
#include "gb_inline.h"
#include "gb_memory.h"
#include "gb_rosenbrock.h"
#include "gb_sparse_ldu.h"
#include "gb_step_constraints.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

enum { FIRST_LOOKS = 8, GAP = 16, LONGEST_GAP = 1024, TRIAL = 4, CALM = 256, IN_A_ROW = 8 };

/* So many steps still to come at the present pace that a trial is worth its cost whatever the reason of the pace. */
static const double MANY_STEPS = 2e4;

/* Steps that could be so much longer, by their error, than what the explicit method reaches are held back by it. */
static const double HELD_BACK = 2.0;

/* With so few steps, of those that are taken, explicit ones would be stable: accuracy and events set the pace, and the
 * method of higher order takes no more of them. */
static const double NOT_STIFF = 0.1;

/* So many that a large implicit step is tried; fastest rate times size of such a step, and from which product on a
 * vibration is stepped over. */
static const double HOPELESS = 1e6, LARGE_STEP = 1e4, STEPPED_OVER = 30.0;

/* Step size times fastest rate at which explicit steps are at the limit of stability or of what they reach
 * (gb_reach.h), and where a look is worth it. */
static double stability(const gb_sim *sim) {
    return sim->head->choice.explicit_method == GB_DP8 ? 4.0 : 3.3;
}

/* What the active rows of constraints add to it: in eight stages, and once a step to factor their matrix. */
static double row_cost(gb_sim *sim) {
    const double rows = gb_tie_unknowns(sim) ? 0.0 : gb_n_active_rows(sim), all = sim->model->pattern->n,
                 speeds = sim->model->n_speeds;
    return 0.26 * rows * (8.0 * (speeds + rows + all) + 3.0 * all + rows * (speeds + rows));
}

/* Cost of an implicit step in explicit ones, counted in right-hand sides; calibrated on a chain. */
static double implicit_cost(gb_sim *sim) {
    const gb_pattern *p = sim->model->pattern;
    const double places = (double)p->n_places / (p->n + 1), pairs = (double)gb_pair_count(p) / (p->n + 1);
    const double solve = p->tree ? 0.2 + 0.4 * places : 0.5 + 0.7 * places;
    const double units = 12.0 + 8.0 * solve + 0.7 * pairs + row_cost(sim) / (p->n + 1);
    return units / (sim->head->choice.explicit_method == GB_DP8 ? 12.0 : 6.0);
}

/* The largest rate of a single unknown against the rest held still: of E x'' + C x' + K x with the diagonals alone. */
static double fastest_rate(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    double *mass = sim->implicit.inverse, *once = sim->implicit.work, *twice = sim->implicit.diag;
    double *const into[] = {mass, once, twice};
    double most = 0.0;
    for (int i = 0; i < 3; i++) {
        model->step_matrix(sim->par, sim->mode, sim->instant.time_terms, sim->y, sim->k1, i * h, into[i],
                           sim->implicit.lower, sim->implicit.upper, sim->implicit.kinematic_terms);
    }
    for (int u = 0; u < model->pattern->n; u++) {
        if (mass[u] > 0.0) {
            const double s1 = once[u] / mass[u] - 1.0, s2 = twice[u] / mass[u] - 1.0;
            const double b = fabs(0.5 * s2 - s1), a = fabs(2.0 * s1 - 0.5 * s2), under = 0.25 * a * a - b;
            const double rate = under > 0.0 ? 0.5 * a + sqrt(under) : sqrt(b);
            most = gb_max(most, rate);
            sim->choice.rate[u] = rate / h;
        } else {
            sim->choice.rate[u] = 0.0;
        }
        sim->choice.inertia[u] = mass[u];
    }
    return most / h;
}

/* Another method from the front on: what the step control knows of the old one is forgotten. */
static void change_method(gb_sim *sim, int method, double h) {
    gb_head *head = sim->head;
    gb_set_method(sim, method);
    memset(sim->control.noise, 0, sizeof(double) * (size_t)sim->model->n_padded);
    memset(head->events.remembered_step, 0, sizeof head->events.remembered_step);
    head->control.noise_at = head->counts.steps;
    head->control.h_noise = head->control.h_weights = head->control.log_error = 0.0;
    head->control.reach_rate = 0.0;
    head->control.reach_at = head->counts.steps;
    head->control.h_next = h;
}

/* By how much a change must pay: more after every recent change, so that near break-even there are few. */
static double margin(const gb_head *head) {
    return 1.3 * gb_min(1.0 + 0.25 * head->choice.restless, 2.5);
}

static void note(gb_head *head) {
    const int at = head->choice.n_switches < GB_KEPT ? head->choice.n_switches : GB_KEPT - 1;
    head->choice.switch_method[at] = head->method;
    head->choice.switch_t[at] = head->front.t1;
    head->choice.n_switches++;
    head->choice.restless++;
    head->choice.calm_at = head->counts.steps + CALM;
}

static void look_later(gb_head *head, int factor) {
    if (head->choice.looks > FIRST_LOOKS) {
        head->choice.gap = head->choice.gap * factor < LONGEST_GAP ? head->choice.gap * factor : LONGEST_GAP;
    }
    head->choice.look_at = head->counts.steps + head->choice.gap;
    head->choice.t_look = head->front.t1;
    head->choice.steps_look = head->counts.steps + head->counts.rejected;
}

void gb_choice_start(gb_sim *sim) {
    gb_head *head = sim->head;
    const gb_options *options = &head->options;
    head->choice.explicit_method = options->rtol <= 1e-3 ? GB_DP8 : GB_DP5;
    head->choice.automatic = options->method == GB_AUTO && !(options->step > 0.0) && sim->model->pattern;
    head->choice.gap = head->choice.look_at = GAP;
    head->choice.t_look = head->front.t1;
    head->choice.held_next = IN_A_ROW;
}

/* The end of a trial, between two tries of a step: h is the step size that the control wants next. */
static void decide(gb_sim *sim, double h) {
    gb_head *head = sim->head;
    head->choice.trial = 0;
    if (h >= head->choice.h_pays) {
        head->choice.looks = 0;
        head->choice.gap = GAP;
        head->choice.held_next = IN_A_ROW;
    } else {
        head->choice.n_switches--;
        head->choice.restless--;
        change_method(sim, head->choice.explicit_method, head->choice.h_explicit);
        if (!head->choice.early) {
            head->choice.looks += FIRST_LOOKS / 2;
            look_later(head, 4);
        }
    }
}

/* Energy of the vibrations that a large step of size h drops: of every speed so fast that it swings many times within.
 */
static double dropped_energy(const gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    double sum = 0.0;
    for (int i = model->n - model->n_speeds; i < model->n; i++) {
        const double rate = sim->choice.rate[i - model->n_kinematic],
                     mass = sim->choice.inertia[i - model->n_kinematic];
        const double change = sim->z[i] - sim->y0[i], swing = rate > 0.0 ? sim->k1[i] / rate : 0.0;
        sum += rate * h > STEPPED_OVER ? 0.5 * mass * (change * change + swing * swing) : 0.0;
    }
    return sum;
}

double gb_large_step_error(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const double *last = sim->k + (size_t)(sim->method->stages - 1) * (size_t)model->n_total;
    double *error = sim->k + (size_t)GB_SLOPE * (size_t)model->n_total, worst = 1e-30, energy = 0.0;
    memcpy(error, last, sizeof(double) * (size_t)model->n_padded);
    gb_rosenbrock_response(sim, error);
    for (int i = 0; i < model->n; i++) {
        worst = gb_max(worst, h * fabs(error[i]) * sim->control.error_weight[i]);
    }
    model->energies(sim->par, sim->mode, sim->lanes.time_terms, sim->y0, sim->scratch.energies);
    for (int i = 0; i < model->n_energies; i++) {
        energy += fabs(sim->scratch.energies[i]);
    }
    const double rtol = sim->head->options.rtol;
    return dropped_energy(sim, h) > rtol * rtol * energy ? 100.0 : log2(worst);
}

double gb_choice_rejected(gb_sim *sim, double h) {
    gb_head *head = sim->head;
    if (head->choice.large_step) { /* it drops too much: back at once, and the next look may try plain implicit steps */
        head->choice.large_step = head->choice.trial = 0;
        head->choice.n_switches--;
        head->choice.restless--;
        change_method(sim, head->choice.explicit_method, head->choice.h_explicit);
        head->choice.look_at = head->counts.steps + 1;
        head->choice.gap /= 2; /* this look and that one count as one */
        return head->control.h_next;
    }
    if (head->choice.trial > 1 && --head->choice.trial == 1) {
        decide(sim, h);
        return sim->method->gamma > 0.0 ? h : head->control.h_next;
    }
    return h;
}

/* Steps have been held back for a while by what the explicit method reaches (gb_reach.h): a vibration that had to be
 * followed has died away. Each time that implicit steps do not pay for all that, this takes twice as long. Near
 * break-even it means nothing. */
static int is_held_back(gb_sim *sim) {
    gb_head *head = sim->head;
    const double reach = sim->method->reach;
    const int held = reach > 0.0 && head->choice.restless == 0 &&
                     head->control.reach_rate * head->control.h_next > HELD_BACK * reach;
    head->choice.held = held ? head->choice.held + 1 : 0;
    if (head->choice.held < head->choice.held_next) {
        return 0;
    }
    head->choice.held_next *= 2;
    return 1;
}

/* The matrix of implicit steps is that of one side of a limit, and that of massless groups with their dampers: what
 * slides along a limit, and springs that friction alone loads, are followed by explicit steps. */
static int follows_slide(gb_sim *sim) {
    gb_head *head = sim->head;
    const gb_model *model = sim->model;
    const int slides =
        head->events.n_sliding > 0 ||
        (model->springs_alone && model->springs_alone(sim->par, sim->mode, sim->instant.time_terms, sim->y) > 0);
    const int implicit = sim->method->gamma > 0.0;
    if (!(head->options.step > 0.0) && (slides ? implicit : head->options.method == GB_RODAS && !implicit)) {
        gb_set_method(sim, slides ? head->choice.explicit_method : GB_RODAS);
        head->choice.trial = 0;
        head->control.h_weights = 0.0;
    }
    return slides;
}

/* Whether the other kind of steps would be cheaper now: tries it, or goes back to it. */
GB_OUT_OF_LINE int choose(gb_sim *sim, double limit) {
    gb_head *head = sim->head;
    const long long count = head->counts.steps + head->counts.rejected - head->choice.steps_look;
    const double span = head->front.t1 - head->choice.t_look, mean = span / (double)(count > 0 ? count : 1);
    if (!(mean > 0.0)) {
        return GB_DONE;
    }
    head->choice.early = is_held_back(sim);
    if (!head->choice.early && head->counts.steps < head->choice.look_at) {
        return GB_DONE;
    }
    int code = gb_time_terms_at(sim, head->front.t1);
    if (code == GB_DONE && !head->front.have_k1) {
        code = gb_first_derivative(sim, &sim->instant);
    }
    if (code != GB_DONE) {
        return code;
    }
    const double rate = fastest_rate(sim, mean), cost = implicit_cost(sim);
    head->counts.jacobians += 3;
    head->choice.looks += !head->choice.early;
    if (head->choice.restless > 0 && head->counts.steps >= head->choice.calm_at) {
        head->choice.restless--;
        head->choice.calm_at = head->counts.steps + CALM;
    }
    if (sim->method->gamma > 0.0) {
        const double stable = span * rate / stability(sim), explicit_steps = gb_max(stable, (double)count);
        const int back = stable < NOT_STIFF * (double)count || margin(head) * explicit_steps < cost * (double)count;
        look_later(head, back ? 4 : 2);
        if (back) {
            change_method(sim, head->choice.explicit_method, gb_min(head->control.h_next, stability(sim) / rate));
            note(head);
        }
        return GB_DONE;
    }
    if (!head->choice.early) {
        look_later(head, 2);
    }
    const double pace = mean * rate / stability(sim), to_come = (limit - head->front.t1) / mean;
    const int odd = head->choice.early || pace > 0.15 || (pace < 0.02 && head->choice.looks > 1);
    const int slow =
        to_come > MANY_STEPS && (head->choice.looks > FIRST_LOOKS || (head->choice.looks > 1 && to_come > HOPELESS));
    if ((odd || slow) && limit - head->front.t1 > TRIAL * cost * mean) {
        head->choice.trial = TRIAL + 1;
        head->choice.h_pays = margin(head) * cost * mean;
        head->choice.h_explicit = head->control.h_next;
        head->choice.large_step = slow && head->choice.looks % 2 == 0 && limit - head->front.t1 > HOPELESS * mean;
        change_method(sim, GB_RODAS,
                      head->choice.large_step ? gb_min(LARGE_STEP / rate, 1e-3 * (limit - head->front.t1))
                                              : cost * mean);
        note(head);
    }
    return GB_DONE;
}

int gb_choice_look(gb_sim *sim, double limit) {
    gb_head *head = sim->head;
    head->choice.large_step = 0;
    if (head->choice.trial > 1 && --head->choice.trial == 1) {
        decide(sim, head->control.h_next);
    }
    if (follows_slide(sim) || !head->choice.automatic || head->choice.trial > 0) {
        return GB_DONE;
    }
    return choose(sim, limit);
}
