#include "gb_step_constraints.h"
#include "gb_active_set.h"
#include "gb_sparse_ldu.h"
#include "gb_vector.h"

int gb_n_active_rows(const gb_sim *sim) {
    return sim->model->n_constraints > 0 ? (int)sim->mode[sim->model->n_switches] : 0;
}

/* Which constraint the j-th of the active rows belongs to. */
static int active_index(const gb_sim *sim, int j) {
    return (int)sim->mode[sim->model->n_switches + GB_ACTIVE_INDEX + j];
}

double gb_along_row(const gb_sim *sim, int j, const double *speeds) {
    const double *row = sim->constraints.row + (size_t)j * (size_t)sim->model->n_speeds;
    double sum = 0.0;
    for (int i = 0; i < sim->model->n_speeds; i++) {
        sum += row[i] * speeds[i];
    }
    return sum;
}

/* The slip of the j-th active row of an answer of the matrix, with what its other unknowns add to it. */
static double slip_of_answer(const gb_sim *sim, int j, const double *x) {
    const gb_model *model = sim->model;
    const int size = model->pattern->n;
    const double *change = sim->implicit.row_change + (size_t)j * (size_t)size;
    double sum = gb_along_row(sim, j, x + model->n - model->n_speeds - model->n_kinematic);
    for (int i = 0; i < size && model->constraint_change; i++) {
        sum += change[i] * x[i];
    }
    return sum;
}

/* Where slips hang on more than the speeds: how. */
static void find_changes(gb_sim *sim) {
    const gb_model *model = sim->model;
    for (int j = 0; j < gb_n_active_rows(sim) && model->constraint_change; j++) {
        double *unknowns = sim->implicit.row_change + (size_t)j * (size_t)model->pattern->n;
        double *states = sim->implicit.row_by_state + (size_t)j * (size_t)(model->n - model->n_speeds);
        model->constraint_change(sim->implicit.kinematic_terms, active_index(sim, j), unknowns, states);
    }
}

void gb_wanted_slips(gb_sim *sim, const double *k) {
    const gb_model *model = sim->model;
    const int first = model->n - model->n_speeds;
    for (int j = 0; j < gb_n_active_rows(sim); j++) {
        const double *states = sim->implicit.row_by_state + (size_t)j * (size_t)first;
        double slip = model->constant_rows ? 0.0 : gb_along_row(sim, j, k + first);
        for (int i = 0; i < first && model->constraint_change; i++) {
            slip += states[i] * k[i];
        }
        sim->constraints.right[j] = sim->method->gamma * slip;
    }
}

/* Speeds by the cluster that they move with as one, held ones in none (-1); 0: the active set is not like ties. */
static int find_clusters(gb_sim *sim, const gb_active_set *a) {
    const gb_model *model = sim->model;
    const int turns = !model->constant_rows || model->driven_rows || model->constraint_change,
              loses = model->constraint_rows->shares || model->heat_of_force, apart = turns || loses;
    const int roots = *a->n_roots;
    int *cluster = sim->implicit.cluster;
    double *gain = sim->implicit.cluster_gain;
    if (apart || roots < 0 || a->tie_start[roots] + *a->n_held != *a->n_rows) {
        return 0;
    }
    for (int i = 0; i < model->n_speeds; i++) {
        cluster[i] = -1;
    }
    for (int q = 0; q < roots; q++) {
        cluster[a->root[q]] = q;
        gain[a->root[q]] = 1.0;
        for (int e = a->tie_start[q]; e < a->tie_start[q + 1]; e++) {
            cluster[a->tied[e]] = q;
            gain[a->tied[e]] = a->tie_gain[e];
        }
    }
    return 1;
}

/* The place in column k of a speed that moves as one with that of step k; -1: there is none. */
static int place_of_tie(const gb_sim *sim, int k, int first) {
    const gb_pattern *p = sim->model->pattern;
    const int own = p->order[k] - first, n = sim->model->n_speeds;
    const int cluster = own >= 0 && own < n ? sim->implicit.cluster[own] : -1;
    for (int place = p->start[k]; place < p->start[k + 1] && cluster >= 0; place++) {
        const int other = p->order[p->row[place]] - first;
        if (other >= 0 && other < n && sim->implicit.cluster[other] == cluster) {
            sim->implicit.tie_gain[k] = sim->implicit.cluster_gain[own] / sim->implicit.cluster_gain[other];
            return place;
        }
    }
    return -1;
}

int gb_tie_unknowns(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int first = model->n - model->n_speeds - model->n_kinematic;
    if (gb_n_active_rows(sim) == 0) {
        return 0;
    }
    const gb_active_set a = gb_active_at(model->constraint_rows, sim->mode + model->n_switches);
    int followers = 0;
    if (!find_clusters(sim, &a)) {
        return 0;
    }
    for (int k = 0; k < model->pattern->n; k++) {
        sim->implicit.tie_place[k] = place_of_tie(sim, k, first);
        followers += sim->implicit.tie_place[k] >= 0;
    }
    return followers == a.tie_start[*a.n_roots];
}

/* Speeds that are at rest for good have an inertia without bound. */
static void hold_at_rest(gb_sim *sim) {
    const gb_model *model = sim->model;
    const gb_active_set a = gb_active_at(model->constraint_rows, sim->mode + model->n_switches);
    const int from = a.tie_start[*a.n_roots];
    for (int e = from; e < from + *a.n_held; e++) {
        sim->implicit.diag[model->n - model->n_speeds - model->n_kinematic + a.tied[e]] = HUGE_VAL;
    }
}

/* The only speed of row j that is not held; -1: there are none or several. */
static int last_speed(const gb_sim *sim, int j, const double *diag) {
    const double *row = sim->constraints.row + (size_t)j * (size_t)sim->model->n_speeds;
    int found = -1;
    for (int i = 0; i < sim->model->n_speeds; i++) {
        if (row[i] != 0.0 && diag[i] < HUGE_VAL) {
            if (found >= 0) {
                return -1;
            }
            found = i;
        }
    }
    return found;
}

/* A speed that is held by one row alone, or by one beside others that are, has an inertia without bound in the step
 * matrix: so nothing of what presses it comes to its neighbours. The forces along the rows would cancel that but for
 * rounding, which moves what is at rest behind it. */
void gb_hold_speeds(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int n = gb_n_active_rows(sim);
    double *diag = sim->implicit.diag + model->n - model->n_speeds - model->n_kinematic;
    sim->implicit.tied = gb_tie_unknowns(sim);
    if (sim->implicit.tied) {
        hold_at_rest(sim);
        return;
    }
    for (int j = 0; j < n; j++) {
        double *row = sim->constraints.row + (size_t)j * (size_t)model->n_speeds;
        model->constraint_row(sim->par, sim->mode, sim->lanes.time_terms, sim->y0, active_index(sim, j), 0, row);
    }
    for (int again = !model->driven_rows; again;) {
        again = 0;
        for (int j = 0; j < n; j++) {
            const int only = last_speed(sim, j, diag);
            if (only >= 0) {
                diag[only] = HUGE_VAL;
                again = 1;
            }
        }
    }
}

/* Adds what a force along the row of constraint i does: torques on the speeds, and heat. */
static void add_force(gb_sim *sim, int i, double force, double *unknowns) {
    const gb_model *model = sim->model;
    const double *time_terms = sim->lanes.time_terms;
    double *row = sim->implicit.work, *torques = unknowns + model->n - model->n_speeds - model->n_kinematic;
    model->constraint_row(sim->par, sim->mode, time_terms, sim->y0, i, 1, row);
    for (int k = 0; k < model->n_speeds; k++) {
        torques[k] += force * row[k];
    }
    if (model->heat_of_force) {
        model->heat_of_force(sim->par, sim->mode, time_terms, sim->y0, i, force, unknowns);
    }
}

/* The forces of rows that follow from others, as far as the j-th of the active rows asks for them. */
static void add_shares(gb_sim *sim, int j, double *unknowns) {
    const gb_model *model = sim->model;
    const gb_active_set active = gb_active_at(model->constraint_rows, sim->mode + model->n_switches);
    for (int d = 0; d < *active.n_shared && model->constraint_rows->shares; d++) {
        add_force(sim, active.shared[d], active.share[(size_t)d * (size_t)model->n_constraints + (size_t)j], unknowns);
    }
}

/* What the step matrix answers to forces along the active rows, S^-1 G', and the inverse of G S^-1 G'. */
void gb_factor_constraints(gb_sim *sim) {
    const gb_model *model = sim->model;
    const int n = gb_n_active_rows(sim), size = n > 0 ? model->pattern->n : 0;
    if (sim->implicit.tied) {
        return;
    }
    find_changes(sim);
    for (int j = 0; j < n; j++) {
        double *answer = sim->implicit.row_response + (size_t)j * (size_t)size;
        memset(sim->implicit.unknown, 0, sizeof(double) * (size_t)size);
        add_force(sim, active_index(sim, j), 1.0, sim->implicit.unknown);
        add_shares(sim, j, sim->implicit.unknown);
        gb_solve(model->pattern, sim->implicit.inverse, sim->implicit.lower, sim->implicit.upper, sim->implicit.unknown,
                 sim->implicit.work, answer);
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            const double room = slip_of_answer(sim, i, sim->implicit.row_response + (size_t)j * (size_t)size);
            sim->implicit.row_room[i * n + j] = i == j && room == 0.0 ? 1.0 : room; /* 0: all of its speeds are held */
            sim->implicit.row_inverse[i * n + j] = i == j ? 1.0 : 0.0;
        }
    }
    gb_gauss_jordan(n, n, sim->implicit.row_room, n, sim->implicit.row_inverse);
}

/* Adds the constraint forces, so that the speeds of x slip as `right` says. */
void gb_constrain_answer(gb_sim *sim, double *x) {
    const gb_model *model = sim->model;
    const int n = gb_n_active_rows(sim), size = n > 0 ? model->pattern->n : 0;
    double *speeds = x + model->n - model->n_speeds - model->n_kinematic;
    for (int i = 0; i < n && !sim->implicit.tied; i++) {
        sim->constraints.right[i] -= slip_of_answer(sim, i, x);
    }
    for (int j = 0; j < n && !sim->implicit.tied; j++) {
        double force = 0.0;
        for (int i = 0; i < n; i++) {
            force += sim->implicit.row_inverse[j * n + i] * sim->constraints.right[i];
        }
        for (int k = 0; k < size; k++) {
            x[k] += force * sim->implicit.row_response[(size_t)j * (size_t)size + (size_t)k];
        }
    }
    if (n > 0 && model->constant_rows) {
        const gb_active_set active = gb_active_at(model->constraint_rows, sim->mode + model->n_switches);
        gb_active_project(model->constraint_rows, &active, NULL, speeds);
    }
}
