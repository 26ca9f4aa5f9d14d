/* GB_AUTO: which method takes the next step. Decides by counts and step sizes alone, never by a clock.
 *
 * While an explicit method runs, the fastest mode of the train is estimated now and then from the diagonal of the step
 * matrix. Where the steps of late are near the limit of stability, or far below what even that mode asks for, a few
 * implicit steps are tried; if they get long enough to pay, the implicit method stays. It goes when explicit steps at
 * the limit of stability would be cheaper. What a change must pay grows with the changes of late, so that near
 * break-even there are few of them. Where very many steps are still to come, a trial is made whatever the reason of
 * their size. Where that many steps are to come that the run would hardly end, one of them is a leap over vibrations
 * whose energy is nothing beside that of the train. Every try that fails and every change back makes the next look come
 * later. */
#include "gb_internal.h"
#include "gb_sparse.h"

enum { FIRST_LOOKS = 8, GAP = 16, LONGEST_GAP = 1024, TRIAL = 4, CALM = 256 };

/* So many steps still to come at the present pace that a trial is worth its cost whatever the reason of the pace. */
static const double MANY_STEPS = 2e4;

/* So many that a leap is tried; fastest rate times size of a leap, and from which product on a shaft counts as leapt.
 */
static const double HOPELESS = 1e6, LEAP = 1e4, LEAPT = 30.0;

/* Step size times fastest rate at which explicit steps are at the limit of stability, and where a look is worth it. */
static double stability(const gb_sim *sim) {
    return sim->head->explicit_method == GB_DP8 ? 6.0 : 3.3;
}

/* Cost of an implicit step in explicit ones, counted in right-hand sides; calibrated on a chain. */
static double implicit_cost(const gb_sim *sim) {
    const gb_pattern *p = sim->model->pattern;
    const double places = (double)p->n_places / (p->n + 1), pairs = (double)gb_pair_count(p) / (p->n + 1);
    const double solve = p->tree ? 0.2 + 0.4 * places : 0.5 + 0.7 * places;
    const double units = 12.0 + 8.0 * solve + 0.7 * pairs;
    return units / (sim->head->explicit_method == GB_DP8 ? 12.0 : 6.0);
}

/* The largest rate of a single unknown against the rest held still: of E x'' + C x' + K x with the diagonals alone. */
static double fastest_rate(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    double *mass = sim->inverse, *once = sim->work, *twice = sim->diag;
    double *const into[] = {mass, once, twice};
    double most = 0.0;
    for (int i = 0; i < 3; i++) {
        model->jacobian(sim->par, sim->mode, sim->tau_one, sim->y, sim->k1, i * h, into[i], sim->lower, sim->upper,
                        sim->kept);
    }
    for (int u = 0; u < model->pattern->n; u++) {
        if (mass[u] > 0.0) {
            const double s1 = once[u] / mass[u] - 1.0, s2 = twice[u] / mass[u] - 1.0;
            const double b = fabs(0.5 * s2 - s1), a = fabs(2.0 * s1 - 0.5 * s2), under = 0.25 * a * a - b;
            const double rate = under > 0.0 ? 0.5 * a + sqrt(under) : sqrt(b);
            most = gb_max(most, rate);
            sim->leap_rate[u] = rate / h;
        } else {
            sim->leap_rate[u] = 0.0;
        }
        sim->leap_mass[u] = mass[u];
    }
    return most / h;
}

/* Another method from the front on: what the step control knows of the old one is forgotten. */
static void change_method(gb_sim *sim, int method, double h) {
    gb_head *head = sim->head;
    gb_set_method(sim, method);
    memset(sim->noise, 0, sizeof(double) * (size_t)sim->model->n_padded);
    memset(head->remembered_step, 0, sizeof head->remembered_step);
    head->noise_at = head->steps;
    head->h_noise = head->h_weights = head->log_error = 0.0;
    head->h_next = h;
}

/* By how much a change must pay: more after every change of late, so that near break-even there are few. */
static double margin(const gb_head *head) {
    return 1.3 * gb_min(1.0 + 0.25 * head->restless, 2.5);
}

static void note(gb_head *head) {
    const int at = head->n_switches < GB_KEPT ? head->n_switches : GB_KEPT - 1;
    head->switch_method[at] = head->method;
    head->switch_t[at] = head->t1;
    head->n_switches++;
    head->restless++;
    head->calm_at = head->steps + CALM;
}

static void look_later(gb_head *head, int factor) {
    if (head->looks > FIRST_LOOKS) {
        head->gap = head->gap * factor < LONGEST_GAP ? head->gap * factor : LONGEST_GAP;
    }
    head->look_at = head->steps + head->gap;
    head->t_look = head->t1;
    head->steps_look = head->steps + head->rejected;
}

void gb_auto_start(gb_sim *sim) {
    gb_head *head = sim->head;
    const gb_options *options = &head->options;
    head->explicit_method = options->rtol <= 1e-4 ? GB_DP8 : GB_DP5;
    head->automatic = options->method == GB_AUTO && !(options->step > 0.0) && sim->model->pattern;
    head->gap = head->look_at = GAP;
    head->t_look = head->t1;
}

/* The end of a trial, between two tries of a step: h is the step size that the control wants next. */
static void decide(gb_sim *sim, double h) {
    gb_head *head = sim->head;
    head->trial = 0;
    if (h >= head->h_pays) {
        head->looks = 0;
        head->gap = GAP;
    } else {
        head->n_switches--;
        head->restless--;
        change_method(sim, head->explicit_method, head->h_explicit);
        head->looks += FIRST_LOOKS / 2;
        look_later(head, 4);
    }
}

/* Energy of the vibrations that a leap of size h drops: of every shaft so fast that it swings many times within. */
static double dropped_energy(const gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    double sum = 0.0;
    for (int i = model->n - model->n_speeds; i < model->n; i++) {
        const double rate = sim->leap_rate[i - model->n_simple], mass = sim->leap_mass[i - model->n_simple];
        const double change = sim->z[i] - sim->y0[i], swing = rate > 0.0 ? sim->k1[i] / rate : 0.0;
        sum += rate * h > LEAPT ? 0.5 * mass * (change * change + swing * swing) : 0.0;
    }
    return sum;
}

/* log2 of the error of a leap in units of the tolerance: its estimate, smoothed once more, so that what the leap damps
 * does not count (Hairer and Wanner 1996, section IV.8); too large where the energy that is dropped is seen at that
 * tolerance. */
double gb_leap_error(gb_sim *sim, double h) {
    const gb_model *model = sim->model;
    const double *last = sim->k + (size_t)(sim->method->stages - 1) * (size_t)model->n_total;
    double *error = sim->k + (size_t)GB_SLOPE * (size_t)model->n_total, worst = 1e-30, energy = 0.0;
    memcpy(error, last, sizeof(double) * (size_t)model->n_padded);
    gb_stiff_response(sim, error);
    for (int i = 0; i < model->n; i++) {
        worst = gb_max(worst, h * fabs(error[i]) * sim->weight[i]);
    }
    model->energies(sim->par, sim->mode, sim->tau, sim->y0, sim->energy);
    for (int i = 0; i < model->n_energies; i++) {
        energy += fabs(sim->energy[i]);
    }
    const double rtol = sim->head->options.rtol;
    return dropped_energy(sim, h) > rtol * rtol * energy ? 100.0 : log2(worst);
}

/* A step of a trial is rejected; h as above, and the step size to go on with. */
double gb_auto_rejected(gb_sim *sim, double h) {
    gb_head *head = sim->head;
    if (head->leap) { /* it drops too much: back at once, and the next look may try plain implicit steps */
        head->leap = head->trial = 0;
        head->n_switches--;
        head->restless--;
        change_method(sim, head->explicit_method, head->h_explicit);
        head->look_at = head->steps + 1;
        return head->h_next;
    }
    if (head->trial > 1 && --head->trial == 1) {
        decide(sim, h);
        return sim->method->gamma > 0.0 ? h : head->h_next;
    }
    return h;
}

/* At the front, before a step that may reach up to `limit`. */
int gb_auto_look(gb_sim *sim, double limit) {
    gb_head *head = sim->head;
    const long long count = head->steps + head->rejected - head->steps_look;
    const double span = head->t1 - head->t_look, mean = span / (double)(count > 0 ? count : 1);
    head->leap = 0;
    if (head->trial > 1 && --head->trial == 1) {
        decide(sim, head->h_next);
    }
    if (!head->automatic || head->steps < head->look_at || head->trial > 0 || !(mean > 0.0)) {
        return GB_DONE;
    }
    int code = gb_columns_at(sim, head->t1);
    if (code == GB_DONE && !head->have_k1) {
        code = gb_first_derivative(sim, sim->tau_one);
    }
    if (code != GB_DONE) {
        return code;
    }
    const double rate = fastest_rate(sim, mean), cost = implicit_cost(sim);
    head->jacobians += 3;
    head->looks++;
    if (head->restless > 0 && head->steps >= head->calm_at) {
        head->restless--;
        head->calm_at = head->steps + CALM;
    }
    if (sim->method->gamma > 0.0) {
        const double explicit_steps = gb_max(span * rate / stability(sim), (double)count);
        const int back = margin(head) * explicit_steps < cost * (double)count;
        look_later(head, back ? 4 : 2);
        if (back) {
            change_method(sim, head->explicit_method, gb_min(head->h_next, stability(sim) / rate));
            note(head);
        }
        return GB_DONE;
    }
    look_later(head, 2);
    const double pace = mean * rate / stability(sim);
    const int odd = pace > 0.15 || (pace < 0.02 && head->looks > 1);
    const int slow = head->looks > FIRST_LOOKS && limit - head->t1 > MANY_STEPS * mean;
    if ((odd || slow) && limit - head->t1 > TRIAL * cost * mean) {
        head->trial = TRIAL + 1;
        head->h_pays = margin(head) * cost * mean;
        head->h_explicit = head->h_next;
        head->leap = slow && head->looks % 2 == 0 && limit - head->t1 > HOPELESS * mean;
        change_method(sim, GB_RODAS, head->leap ? gb_min(LEAP / rate, 1e-3 * (limit - head->t1)) : cost * mean);
        note(head);
    }
    return GB_DONE;
}
