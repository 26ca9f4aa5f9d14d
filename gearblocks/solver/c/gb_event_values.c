#include "gb_event_values.h"
#include "gb_dense_output.h"
#include "gb_modes.h"
#include "gb_time_terms.h"
#include "gb_vector.h"

int gb_event_functions_at(gb_sim *sim, double theta, double *s) {
    const gb_head *head = sim->head;
    const int code = gb_time_terms_at(sim, head->front.t0 + theta * head->front.h);
    if (code == GB_DONE) {
        gb_dense_states(sim, theta, sim->z2);
        sim->model->event_functions(sim->par, sim->mode, sim->instant.time_terms, sim->z2, s);
    }
    return code;
}

double gb_limit_distance(const gb_sim *sim, int i, double side, double s) {
    const double limit = side < 0.0 ? sim->events.lo[i] : sim->events.hi[i];
    const double rounding = gb_limit_rounding(sim, i, limit);
    /* one that has just flipped is on its limit as well as its root was found, or inside: its law may jump with it */
    const double from = side * (limit - sim->events.s0[i]) <= rounding ? sim->events.s0[i] : limit;
    return side * (from - s) + gb_max(sim->events.slack[i], 0.0);
}

int gb_true_root(gb_sim *sim, int i, double side, double a, double b, double fa, double fb, double tolerance,
                 double *root) {
    int code = GB_DONE;
    for (int count = 0; count < 100 && b - a > tolerance && code == GB_DONE; count++) {
        double x = a + (b - a) * (fa / (fa - fb));
        if (count % 4 == 3 || !(x > a && x < b)) {
            x = 0.5 * (a + b);
        }
        code = gb_event_functions_at(sim, x, sim->events.s);
        const double f = gb_limit_distance(sim, i, side, sim->events.s[i]);
        if (f < 0.0) {
            b = x;
            fb = f;
            fa *= 0.5;
        } else {
            a = x;
            fa = f;
            fb *= 0.5;
        }
    }
    *root = 0.5 * (a + b);
    return code;
}

int gb_true_dip(gb_sim *sim, int i, double side, double a, double m, double b, double fm, double *x, double *f) {
    const double golden = 0.3819660112501051;
    int code = GB_DONE;
    *x = m;
    *f = fm;
    for (int count = 0; count < 30 && *f >= 0.0 && b - a > 1e-5 && code == GB_DONE; count++) {
        const double trial = b - m > m - a ? m + golden * (b - m) : m - golden * (m - a);
        code = gb_event_functions_at(sim, trial, sim->events.s);
        const double value = gb_limit_distance(sim, i, side, sim->events.s[i]);
        if (value < *f) {
            if (trial > m) {
                a = m;
            } else {
                b = m;
            }
            m = *x = trial;
            *f = value;
        } else if (trial > m) {
            b = trial;
        } else {
            a = trial;
        }
    }
    return code;
}
