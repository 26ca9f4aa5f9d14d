/* What the files of the solver share. Not for callers: they see gb_core.h alone. */
#ifndef GB_INTERNAL_H
#define GB_INTERNAL_H

#include "gb_core.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

enum {
    GB_STAGES = 16, /* stages of a method, those of dense output included; one lane each */
    GB_NODES = 2,   /* of the quadratures of an implicit method */
    GB_SPARE = 12,  /* slots of k for the states at the nodes; the next one holds h df/dt */
    GB_SLOPE = 14,
    GB_ROWS = 8,    /* rows of a dense polynomial */
    GB_EIGHTHS = 8, /* interior samples of a surface */
    GB_MEMORY = 64, /* remembered step sizes */
    GB_FLIPS = 20   /* flips of one switch without progress of time before the run stops */
};

/* The non-zero entries of one row of a tableau. */
typedef struct gb_weights {
    int count, index[GB_STAGES];
    double value[GB_STAGES];
} gb_weights;

/* Who decides about the mode of a switch: its quantity alone, all locks together (gb_lock.c), or its quantity without
 * an event of its own. */
enum { GB_ORDINARY, GB_LOCKED, GB_SILENT };

/* A one-step method; see Tableau in methods.py and, for implicit ones (gamma > 0), Rosenbrock in rosenbrock.py. */
typedef struct gb_method {
    int order, stages, all_stages, rows, n_errors, error_order;
    double beta, c[GB_STAGES];
    int full[GB_STAGES];                    /* the tail is needed at this stage */
    gb_weights a[GB_STAGES];                /* row `stages` is b */
    gb_weights e[2];                        /* error estimates */
    gb_weights d[GB_ROWS];                  /* dense rows; the first three are formed without them */
    double dense[GB_ROWS][GB_STAGES];       /* those of the tail in full */
    double gamma;                           /* 0: explicit */
    double slope[GB_STAGES];                /* weights of h df/dt */
    double stage[GB_STAGES][2][GB_STAGES];  /* of the stages before: in the state, in the right side */
    double points[1 + GB_NODES][GB_STAGES]; /* of the stages: the new state, the states at the nodes */
    double inside[GB_NODES + 2][GB_STAGES]; /* dense rows in full */
    gb_weights tail[GB_ROWS];               /* dense rows of the tail */
} gb_method;

typedef struct gb_source {
    int kind, points;
    const double *x, *y, *y2;
    double period;
    gb_input_fn fn;
    void *user;
} gb_source;

/* The head of the block that changes during a run. No pointers. */
typedef struct gb_head {
    uint64_t key;
    uint64_t bytes;
    gb_options options;
    gb_report report;
    double t_start;
    double t0, h;     /* the dense polynomial is y0 at t0 and spans h; the segment ends at t1, where y is */
    double t1;        /* the front */
    double t_comm;    /* the communication point, in [t0, t1] */
    double h_next;    /* proposed by the step control */
    double h_largest; /* of all accepted steps */
    double h_weights; /* step size for which the error weights were made */
    double h_worked;  /* the last accepted size, or the proposed one if that is smaller */
    double log_error; /* of the last accepted step, base 2 */
    double t_break;   /* the next announced instant: time switches and tables */
    double turnover, turnover_segment, stored; /* stored: the largest that a look at it found */
    long long steps, rejected, rhs_calls, events, jacobians, noise_at;
    long long steps_by[GB_METHODS];
    long long floor_at; /* when the floors of the sizes are due */
    double t_weights;   /* time for which the error weights were made */
    double h_noise;     /* step size for which the noise was measured */
    long sample;        /* samples of the present gb_run that are done */
    int started;
    int method; /* that of the next step */
    /* GB_AUTO: */
    int automatic, explicit_method;
    int leap;                      /* the next step is a leap */
    int trial;                     /* > 1: tries of implicit steps until it is decided, less one */
    int looks, gap;                /* how often it was considered of late, and how many steps there are between */
    long long look_at, steps_look; /* the next look; steps, rejected ones too, at the last one */
    int restless;                  /* changes of the method of late */
    long long calm_at;             /* when one of them is forgotten */
    double t_look, h_explicit, h_pays;
    int n_switches, switch_method[GB_KEPT];
    double switch_t[GB_KEPT];
    int changed;    /* parameters or inputs were written */
    int have_k1;    /* k holds the derivative at the front */
    int have_dense; /* rows are complete in the first n states */
    int have_tail;  /* and in the tail */
    int pending;    /* an event waits at the front */
    int row_due;    /* the front is not recorded yet */
    int sitting;    /* some switch has just flipped: its `on` is set */
    int poor;       /* a state has no size yet: weights follow the trial step */
    uint64_t modes; /* hash of all modes */
    uint64_t remembered_modes[GB_MEMORY];
    double remembered_step[GB_MEMORY];
} gb_head;

struct gb_sim {
    const gb_model *model;
    const gb_method *method;
    void *memory;
    gb_head *head; /* the block begins here and has block_bytes */
    size_t block_bytes;

    /* In the block. By parameter and input: */
    double *par, *input;
    double *cell, *cell_end; /* the segment of its table and where it ends */
    double *lock_size;       /* by lock: sizes of the rows */
    /* by switch: */
    double *mode, *lo, *hi;
    double *on;                /* -1 or 1: it has just flipped and sits on its lower or upper limit */
    double *due, *next_mode;   /* due != 0: it flips at the front, into next_mode */
    double *next_time;         /* time switches: when they leave their mode (into next_mode) */
    double *flip_time, *flips; /* the last flip, and how many without progress */
    /* by state: */
    double *peak, *scale, *noise, *weight, *floor, *y0, *y;
    double *k1;   /* the derivative at the front */
    double *rows; /* dense rows, each n_total long; the block ends here */

    /* Outside the block. */
    double *k;                         /* derivatives by stage, each n_total long */
    double *z, *z2, *zero;             /* stage states, length n_total */
    double *energy;                    /* all energies of one instant */
    double *z_out;                     /* all outputs of one row */
    double *z_input;                   /* all inputs of one instant */
    double *t, *u, *tau;               /* lanes of a step */
    double *t_one, *u_one, *tau_one;   /* lanes of single instants */
    double *s0, *s, *slopes, *samples; /* surfaces: at the start, at an instant, along rows, at the eighths */
    double *root, *side;
    double *diag, *inverse, *lower, *upper, *kept; /* the matrix of an implicit step */
    double *work, *unknown;
    double *leap_rate, *leap_mass; /* by unknown, at the last look */
    int *colour, *link, n_colours; /* by unknown; by simple state and colour: the unknown in its rate, or -1 */
    double *gain;                  /* and one over its factor */
    double stiff_h;                /* the step size it was made for */
    double *before;                /* modes before an event */
    double flight;                 /* until a body that has just hit a stop is back */
    int untold;                    /* samples of the last watch do not tell what a held force does */
    int *role;                     /* by switch: who decides about its mode */
    /* What sticks, by lock (scratch of an event): slips and their rounding, limits, matrices, forces; */
    double *slip, *slip_rounding, *limit, *response, *lock_matrix, *lock_right, *lock_lo, *lock_hi, *lock_force;
    double *lock_other, *lock_old, *lock_before, *lock_bare, *lock_mode, *shrink, *other_mode;
    double *base_mode, *base_sign, *best_mode, *best_rate;
    const double *look; /* the state by which it is decided */
    double fastest;     /* of the accelerations when nothing is held */
    int lock_count, *base_state, *best_state, *option;
    int *lock_index, *lock_state, *was_shared, *released, *struck;
    double *grip, *grip_answer, *grip_inverse; /* rows of what holds, what an implicit step answers to them */
    gb_source *sources;
    int *moving, n_moving; /* inputs that are no constants */
    gb_event *log;
    long n_log, n_flushed, log_capacity;
};

static inline double gb_max(double a, double b) {
    return a > b ? a : b;
}
static inline double gb_min(double a, double b) {
    return a < b ? a : b;
}

/* How far beyond a limit switch i may go by rounding. A state that comes to rest on the limit of a continuous law moves
 * by the rounding of rates that cancel: each flip without progress of time doubles it, until the next that stands
 * alone. */
static inline double gb_limit_rounding(const gb_sim *sim, int i, double limit) {
    return ldexp(64.0 * DBL_EPSILON * (fabs(sim->s0[i]) + fabs(limit)),
                 sim->flips[i] > 1.0 ? (int)sim->flips[i] - 1 : 0);
}

/* How finely an instant can be told near t in a step of size h. */
static inline double gb_rounding(double t, double h) {
    return 100.0 * DBL_EPSILON * (fabs(t) + fabs(h));
}

/* gb_open.c */
int gb_fail(gb_sim *sim, int code, int index, double t, double value);
int gb_check_finite(gb_sim *sim, int code, const double *x, int count, int shift, double t);
int gb_apply_changes(gb_sim *sim);
void gb_set_method(gb_sim *sim, int method);

/* gb_input.c */
void gb_input_find(gb_sim *sim, double t, int log);
int gb_input_lanes(gb_sim *sim, int lanes, const double *t, double *u);
int gb_input_values(gb_sim *sim, double t, double *value);
void gb_input_broadcast(gb_sim *sim);

/* gb_step.c: one accepted step from the front, to `stop` at most; marks what flips at its end. */
int gb_step(gb_sim *sim, double stop);
int gb_columns(gb_sim *sim, int lanes, double *t, double *u, double *tau);
int gb_columns_at(gb_sim *sim, double t);
int gb_first_derivative(gb_sim *sim, const double *tau);

/* gb_probe.c */
int gb_point_columns(gb_sim *sim, const gb_point *at);

/* gb_turns.c: angles whose turns are counted. */
double gb_turns_step(const gb_sim *sim, double h);
void gb_turns_advance(gb_sim *sim);
void gb_turns_rows(gb_sim *sim, int from, int to);
int gb_turns_wrap(gb_sim *sim, int with_modes);

/* gb_kernel.c: the sums and calls of a step. */
void gb_run_stages(gb_sim *sim, double h);
void gb_run_extra_stages(gb_sim *sim, double h);
double gb_log_error(const gb_sim *sim, double h);
double gb_log_exchange_error(gb_sim *sim, double h);

/* gb_stiff.c: the same for implicit methods. */
void gb_stiff_links(gb_sim *sim);
void gb_stiff_floor(gb_sim *sim);
int gb_stiff_lanes(const gb_sim *sim, double from, double h, double *t);
int gb_stiff_stages(gb_sim *sim, double h);
void gb_stiff_tail(gb_sim *sim, double h);
void gb_stiff_response(gb_sim *sim, double *change);

/* gb_auto.c: the choice of the method. */
void gb_auto_start(gb_sim *sim);
int gb_auto_look(gb_sim *sim, double limit);
double gb_auto_rejected(gb_sim *sim, double h);
double gb_leap_error(gb_sim *sim, double h);

/* gb_control.c: weights and step sizes. */
void gb_weights_refresh(gb_sim *sim, double h, const double *tau, const double *trial);
void gb_weights_grow(gb_sim *sim, const double *y);
int gb_worst_state(const gb_sim *sim);
double gb_step_factor(gb_sim *sim, double log_error, int accepted);
double gb_first_step(gb_sim *sim);

/* gb_dense.c */
void gb_dense_hermite(gb_sim *sim);
int gb_dense_complete(gb_sim *sim);
int gb_dense_tail(gb_sim *sim);
void gb_dense_states(const gb_sim *sim, double theta, double *out);
void gb_dense_all(const gb_sim *sim, double t, double *out);
void gb_dense_cut(gb_sim *sim, double theta);

/* gb_watch.c: the first theta in the step at which switches leave their modes (they are marked as due); *theta is 2 if
 * there is none. gb_surface.c does the same for surfaces that are not affine. */
int gb_watch(gb_sim *sim, double *theta);
int gb_watch_general(gb_sim *sim);

/* gb_lock.c: what sticks. */
int gb_settle_locks(gb_sim *sim, int log);
void gb_remember(gb_sim *sim, double *mode, const double *tau, const double *y);
const double *gb_full_modes(gb_sim *sim, const double *mode, const double *tau, const double *y);
int gb_project(gb_sim *sim, const double *tau);
void gb_size_locks(gb_sim *sim);

/* gb_event.c */
int gb_modes_start(gb_sim *sim, int fresh);
int gb_count_flip(gb_sim *sim, int i);
void gb_rehash(gb_sim *sim);
int gb_settle(gb_sim *sim, int log);
int gb_apply_event(gb_sim *sim);
void gb_refresh_breaks(gb_sim *sim, int all);
void gb_time_modes(gb_sim *sim, int log);
void gb_mark_time_events(gb_sim *sim);
void gb_mark_modes(gb_sim *sim);
int gb_surfaces_now(gb_sim *sim);
void gb_set_mode(gb_sim *sim, int i, double mode, int log);
void gb_log(gb_sim *sim, int index, int kind, double before, double after);

#endif
