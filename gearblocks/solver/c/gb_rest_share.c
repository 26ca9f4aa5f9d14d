#include "gb_rest_share.h"
#include "gb_loss.h"
#include "gb_vector.h"

enum { KNOTS = 6 };
static const double FAR = 1e9;     /* shares so far beyond their ends are looked at */
static const double SAME = 1e-12;  /* of the terms of a difference: what is left of it is nothing */
static const double POINT = 1e-12; /* a range that is empty by so little is a point */

/* Shares from least to most, and the one that is taken of them (NAN: there are none). */
typedef struct range {
    double least, most;
} range;

static double nearest_to_half(const range *of) {
    if (of->least > of->most + POINT * (1.0 + fabs(of->least))) {
        return NAN;
    }
    return of->least > of->most ? 0.5 * (of->least + of->most) : gb_min(gb_max(0.5, of->least), of->most);
}

/* Leaves the shares at which room, `at` at 0 and `above` at 1, is not negative. */
static void leave_room(range *of, double at, double above) {
    const double slope = above - at;
    if (slope > 0.0) {
        of->least = gb_max(of->least, -at / slope);
    } else if (slope < 0.0) {
        of->most = gb_min(of->most, -at / slope);
    } else if (at < 0.0) {
        of->least = HUGE_VAL;
    }
}

gb_held_force gb_held_force_in(gb_sim *sim, const double *mode, const double *time_terms, const double *y, int c) {
    const gb_model *model = sim->model;
    struct gb_constraints *own = &sim->constraints;
    gb_held_force in = {0};
    model->force_bounds(sim->par, mode, time_terms, y, own->bounds);
    model->constraint_forces(sim->par, mode, time_terms, y, own->lo, own->right);
    memcpy(in.bounds, own->bounds + 5 * c, sizeof in.bounds);
    in.force = own->lo[c];
    in.tie = model->constraints[c].kind == GB_LOSS ? own->lo[model->constraints[c].partner] : 0.0;
    return in;
}

void gb_held_range(const gb_sim *sim, int c, const gb_held_force *in, double range[2]) {
    const int lossy = sim->model->constraints[c].kind == GB_LOSS;
    range[0] = lossy ? -gb_loss_of(in->bounds, in->tie) : in->bounds[0];
    range[1] = lossy ? gb_loss_of(in->bounds, -in->tie) : in->bounds[1];
}

/* Of a friction: the share within its bounds. Bounds that cross lie beyond the ends. */
static double share_within(const gb_held_force in[2]) {
    range of = {-HUGE_VAL, HUGE_VAL};
    leave_room(&of, in[0].force - in[0].bounds[0], in[1].force - in[1].bounds[0]);
    leave_room(&of, in[0].bounds[1] - in[0].force, in[1].bounds[1] - in[1].force);
    return of.least >= HUGE_VAL ? 2.0 : of.least > of.most ? of.least : nearest_to_half(&of);
}

/* Where the force of the tie changes its side, in order, between ends that are far. */
static int find_knots(const gb_held_force in[2], double *knot) {
    const double slope = in[1].tie - in[0].tie, *losses = in[0].bounds;
    const double sides[KNOTS - 2] = {losses[1], -losses[1], losses[3], -losses[3]};
    int n = 0;
    knot[n++] = -FAR;
    knot[n++] = FAR;
    for (int k = 0; k < KNOTS - 2; k++) {
        const double at = (sides[k] - in[0].tie) / slope;
        int place = n;
        if (!(fabs(at) < FAR)) {
            continue;
        }
        for (; knot[place - 1] > at; place--) {
            knot[place] = knot[place - 1];
        }
        knot[place] = at;
        n++;
    }
    return n;
}

/* Of a lossy gear, whose losses are a line over the force of its tie on each side of it. */
static double share_of_loss(const gb_held_force in[2]) {
    const double *losses = in[0].bounds;
    double knot[KNOTS], best = NAN;
    const int n = find_knots(in, knot);
    for (int k = 0; k + 1 < n; k++) {
        const double tie = in[0].tie + 0.5 * (knot[k] + knot[k + 1]) * (in[1].tie - in[0].tie);
        const gb_loss_line up = gb_loss_on_side(losses, gb_loss_side(losses, tie)),
                           down = gb_loss_on_side(losses, gb_loss_side(losses, -tie));
        double above[2], below[2];
        for (int j = 0; j < 2; j++) {
            above[j] = in[j].force + up.slope * in[j].tie + up.fixed;
            below[j] = down.fixed - down.slope * in[j].tie - in[j].force;
        }
        range of = {knot[k], knot[k + 1]};
        leave_room(&of, above[0], above[1]);
        leave_room(&of, below[0], below[1]);
        const double share = nearest_to_half(&of);
        best = !(fabs(best - 0.5) <= fabs(share - 0.5)) && share == share ? share : best;
    }
    return best == best ? best : 2.0;
}

/* The law has no jump there any more: what is asked for is the same on both sides. */
static int asks_alike(const gb_held_force in[2]) {
    return fabs(in[1].force - in[0].force) <= SAME * (fabs(in[0].force) + fabs(in[1].force)) &&
           fabs(in[1].tie - in[0].tie) <= SAME * (fabs(in[0].tie) + fabs(in[1].tie));
}

double gb_rest_share(const gb_sim *sim, int c, const gb_held_force in[2]) {
    if (asks_alike(in)) {
        return 2.0;
    }
    return sim->model->constraints[c].kind == GB_LOSS ? share_of_loss(in) : share_within(in);
}
