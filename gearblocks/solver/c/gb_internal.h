/* The structs of the solver, by concern. Not for callers: they see gb_core.h alone. Knows nothing of what is done with
 * them: every file has a header with its functions. */
#ifndef GB_INTERNAL_H
#define GB_INTERNAL_H

#include "gb_core.h"
#include "gb_patience.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

enum {
    GB_STAGES = 16, /* stages of a method, those of dense output included; one lane each */
    GB_NODES = 2,   /* of the quadratures of an implicit method */
    GB_SPARE = 12,  /* slots of k for the states at the nodes; the next one holds h df/dt */
    GB_SLOPE = 14,
    GB_ROWS = 8,          /* rows of a dense polynomial */
    GB_EIGHTHS = 8,       /* interior samples of an event function */
    GB_PANEL_POINTS = 13, /* of polynomials of event functions' arguments: 9 that fit, 4 that check */
    GB_HELD = -2,         /* of `resting`: its rate is none, and the mean keeps that of the rate none */
    GB_SLIDING = 4,       /* switches that slide along their limit at a time */
    GB_FLIPS = 20         /* flips of one switch without progress of time before the run stops */
};

/* The non-zero entries of one row of a tableau. */
typedef struct gb_weights {
    int count, index[GB_STAGES];
    double value[GB_STAGES];
} gb_weights;

/* Who decides about the mode of a switch: its event function alone, all switched constraints together, or its event
 * function without an event of its own. */
enum { GB_ORDINARY, GB_CONSTRAINED, GB_SILENT };

/* A one-step method; see Tableau in methods.py and, for implicit ones (gamma > 0), Rosenbrock in rosenbrock.py. */
typedef struct gb_method {
    int order, stages, all_stages, rows, n_errors, error_order;
    double beta, reach; /* h lambda up to which the estimates and the dense polynomial tell the error, 0: all */
    double defect[2];   /* theta where the defect of the dense polynomial is looked at, its error over h times that, 0:
                           not looked at */
    double c[GB_STAGES];
    int full[GB_STAGES];                      /* quadratures are needed at this stage */
    gb_weights a[GB_STAGES];                  /* row `stages` is b */
    gb_weights e[2];                          /* error estimates */
    gb_weights d[GB_ROWS];                    /* dense rows; the first three are formed without them */
    double dense[GB_ROWS][GB_STAGES];         /* those of the quadratures in full */
    double gamma;                             /* 0: explicit */
    double slope[GB_STAGES];                  /* weights of h df/dt */
    double instants[2], time_slope[GB_LANES]; /* beside the stages, and weights of h du/dt over all of these */
    double stage[GB_STAGES][2][GB_STAGES];    /* of the stages before: in the state, in the right side */
    double points[1 + GB_NODES][GB_STAGES];   /* of the stages: the new state, the states at the nodes */
    double inside[GB_NODES + 2][GB_STAGES];   /* dense rows in full */
    double angles[GB_NODES + 2][GB_STAGES];   /* dense rows of angles over the stages of their speeds */
    gb_weights quadratures[GB_ROWS];          /* dense rows of the quadratures */
} gb_method;

typedef struct gb_source {
    int kind, points;
    const double *x, *y, *y2;
    double period;
    gb_input_fn fn;
    void *user;
} gb_source;

/* Where the run stands. The dense polynomial is y0 at t0 and spans h; the segment ends at the front t1, where y is. */
struct gb_front {
    double t_start, t0, h, t1;
    double t_comm;        /* the communication point, in [t0, t1] */
    long sample;          /* samples of the present gb_run that are done */
    int row_due;          /* the front is not recorded yet */
    int have_k1;          /* k holds the derivative at the front */
    int have_dense;       /* rows are complete in the first n states */
    int have_quadratures; /* and in the quadratures */
};

/* States without a tolerance scale: so small, or never other than 0, in the trial step neither. */
enum { GB_SMALL = 1, GB_AT_REST = 2 };

/* Step control. */
struct gb_pace {
    double h_next, h_largest;             /* proposed; of all accepted steps */
    double h_worked;                      /* the last accepted size, or the proposed one if that is smaller */
    double h_weights, t_weights, h_noise; /* size and time for which the error weights were made; for the noise */
    double log_error;                     /* of the last accepted step, base 2 */
    double h_feature;                     /* see gb_features.h: limit of the next step, 0: none */
    double h_trusted, defect_gap;         /* dense polynomials proved right up to it; steps from look to look inside */
    double reach_rate, reach_h;           /* of the last look: the fastest rate, the step (gb_reach.h) */
    long long reach_at, reach_gap;        /* when to look again, and how many steps later once more */
    uint64_t reach_modes, noise_modes;    /* of the last look; those in which the noise was measured */
    long long noise_at, least_scale_at;   /* when noise and least scales are to be renewed */
    long long refused_at, defect_at;      /* the last step with a refused trial, from 1 on; the next look inside */
    double log_refused;                   /* error of the trial that was refused last, base 2 */
    unsigned noise_pattern, doublings;    /* measurements of noise and doublings of what they find, so far */
    double natural, natural_coordinate;   /* the largest natural scale of a speed (-1: not known) and of a coordinate */
    double least_speed, least_coordinate; /* what has not been larger has no scale */
    int moved, unscaled, noisy; /* see gb_rest.h; states without a scale: GB_SMALL, GB_AT_REST; tolerances are noise */
    double cut_error[GB_MEMORY];
    gb_patience cuts; /* with cuts: see gb_cut.h */
};

/* Energies that steps exchange, and what the last look at their error found. */
struct gb_ledger {
    double turnover, turnover_segment;
    double stored;               /* the largest that a look at it found */
    double noise;                /* of the powers, all together */
    double found, h_found;       /* what the last look that was content found there, and its step size */
    uint64_t found_modes;        /* the modes there */
    long long found_at, look_at; /* steps that were done at that look, and at the next one */
    uint64_t modes[GB_MEMORY];   /* modes that were looked at */
    double h_known[GB_MEMORY];   /* a longer step in them is looked at */
    gb_patience cuts;            /* with integrals of cut steps */
};

/* Drift of the energy balance, see gb_drift.h. */
struct gb_drift {
    double sum, last;                         /* so far; the balance at the last look */
    double turnover, t_look;                  /* at the last look, and when that was */
    double chosen, t_chosen, turnover_chosen; /* sum, time and turnover when strictness was chosen */
    double rate, strictness;                  /* of the drift without strictness; what is added to the log2 of errors */
    int based, tries;                         /* `last` is a balance; how often strictness was of no use */
    int imbalanced; /* a try of the present step was out of balance: by how much as log2, and its size */
    double imbalance, h_imbalance;
    long long balance_at, balance_gap;  /* steps when tries are looked at again, and how many were left out before */
    long long look_at, gap, look_event; /* steps at the next look, and how many there are between; events, likewise */
};

/* Motion that grows without bound, see gb_growth.h. */
struct gb_growth {
    int wrong; /* fixed steps with an error of the size of the motion, weighed against those without */
    double look_at, t_look, pace, speed; /* steps at the next look at the pace; of the last: time, mean step, speed */
};

struct gb_counts {
    long long steps, rejected, rhs_calls, events, jacobians;
    long long steps_by[GB_METHODS];
};

/* GB_AUTO. */
struct gb_choice {
    int automatic, explicit_method;
    int large_step, early; /* the next step is a large implicit one; the last look came early, for those held back */
    int trial;             /* > 1: tries of implicit steps until it is decided, less one */
    int looks, gap;        /* how often it was considered lately, and how many steps there are between */
    long long look_at, steps_look; /* the next look; steps, rejected ones too, at the last one */
    int restless;                  /* recent changes of the method */
    long long calm_at;             /* when one of them is forgotten */
    long long held, held_next; /* steps in a row that only the reach of the method holds back; how many are looked at */
    double t_look, h_explicit, h_pays;
    int n_switches, switch_method[GB_KEPT];
    double switch_t[GB_KEPT];
};

/* Events. */
struct gb_event_state {
    double t_break;     /* the next announced instant: time switches and tables */
    int pending, armed; /* an event waits at the front; some switch has just flipped and is watched from its limit */
    double flight;      /* how long a body that has just hit a stop is away (HUGE_VAL: none) */
    double flight_end;  /* and until when that may still be so, friction changing its pace */
    double piece;       /* length of the piece of a step in which a crossing was enclosed last (0: none yet) */
    double entered;     /* the last event: the present modes began there */
    double held_until;  /* the first limit that is not watched is so no more (HUGE_VAL: none) */
    double look_ahead;  /* > 0: how far ahead the motion tells what constraints do from here */
    long long look_at, look_gap;     /* events when rests on limits are looked at again; how many lie between */
    long long crowd, tries;          /* events, refused tries when it was last asked whether they let time go on, */
    double t_crowd, t_tries, target; /* then; the end of the present gb_run */
    double rested_at[GB_SLIDING], reach[GB_SLIDING], admitted[GB_SLIDING]; /* see gb_limit_bend.h */
    int forces_agreed; /* enclosed constraint forces were right at the start of a step since the modes changed */
    int n_sliding, sliding[GB_SLIDING], resting[GB_SLIDING]; /* see gb_sliding.h, gb_rates.h */
    uint64_t mode_hash, by_mean, turned; /* of all modes; bits: constraints that a mean holds, see gb_turned_gears.h */
    uint64_t remembered_modes[GB_MEMORY];
    double remembered_step[GB_MEMORY];
};

/* The head of the block that changes during a run. No pointers. */
typedef struct gb_head {
    uint64_t key, bytes;
    uint64_t checksum; /* of a saved block; see gb_snapshot.h */
    gb_options options;
    gb_report report;
    int started;
    int changed; /* parameters or inputs were written */
    int method;  /* that of the next step */
    struct gb_front front;
    struct gb_pace control;
    struct gb_ledger ledger;
    struct gb_drift drift;
    struct gb_growth growth;
    struct gb_counts counts;
    struct gb_choice choice;
    struct gb_event_state events;
} gb_head;

/* Inputs. In the block: value, cell, cell_end. */
struct gb_input_memory {
    double *value;
    double *cell, *cell_end; /* the segment of its table and where it ends; of a callback: where it jumps */
    gb_source *source;
    int *moving, n_moving, n_callbacks; /* inputs that are no constants; how many of these are callbacks */
};

/* Error weights, by state; in the block. */
struct gb_control {
    double *largest;       /* size so far */
    double *natural_scale; /* of the train, 0: none */
    double *least_scale;   /* implicit methods: see gb_rosenbrock.h */
    double *noise;         /* of its rate */
    double *error_weight;  /* 1 / (rtol scale + h noise) */
    double *fastest_rate;  /* largest rate so far of twists of massless groups: see gb_massless_error.h */
    double *fast;          /* direction of the fastest motion: see gb_reach.h */
};

/* Instants, GB_LANES of them: inputs and time terms there. */
typedef struct gb_lanes {
    double *t, *u, *time_terms;
} gb_lanes;

/* Events, by switch. In the block: up to `stayed`. */
struct gb_events {
    double *lo, *hi;
    double *armed;               /* -1 or 1: it has just flipped and is watched from its lower or upper limit */
    double *pending, *next_mode; /* pending != 0: it flips at the front, into next_mode */
    double *next_time;           /* time switches: when they leave their mode (into next_mode) */
    double *flip_time, *flips;   /* the last flip, and how many without progress */
    double *held, *held_side, *shortest, *shortest_at, *swings, *swings_from, *stayed; /* see gb_swings.h */
    double *defect;                    /* slopes of a dense polynomial and rates there, by state */
    int *role, *slip_of, *force_of;    /* who decides about its mode; the constraint whose slip or force it is, or -1 */
    double *mode_before;               /* modes before an event */
    double *s0, *s, *slopes, *samples; /* event functions: at the start of a step, at an instant, along rows, sampled */
    double *moved, *until;             /* and with one state moved; just after the first constraint force that leaves */
    double *located, *side;            /* theta at which it leaves its mode, and the limit */
    double *slack;                     /* sign of the force of a lossy gear: how far beyond counts as on it; else -1 */
    int undersampled;                  /* 1 + one of which neither samples nor pieces of the last step tell all */
    int in_doubt;                      /* 1 + one where its polynomial takes back at once what its start decided */
    int again;                         /* how often this step was cut short for these, or by gb_cut.h */
    double part;                       /* of it that is tried again */
};

/* Without location. */
struct gb_unlocated {
    double *mode;       /* of the stage; behind them the active set */
    size_t n_carried;   /* doubles of it that are those of the step */
    int lanes, crossed; /* with time terms; a mode changed between two stages of the step */
};

/* Rates beside limits along which switches slide: modes, time terms, rates, a state, functions and outputs there. */
struct gb_sliding {
    double *mode, *rates, *state, *functions, *outputs;
    gb_lanes lanes;
};

/* Enclosures of event functions over a piece of a step. values: arguments at the points of a panel; of those that are
 * read, bernstein: what they are along it, slack: how far off, misfit: the same in the last panel, rounding: what
 * shorter ones do not mend; x: all arguments over a piece; left, right: event functions at its ends, noise: how finely
 * told there; watched: those enclosed in this step; response: constraint forces per torque (unit) on each group. */
struct gb_panel {
    double from, to, kept_reach, ahead, far; /* far: more than functions of the states of this step round by */
    double *values, *bernstein, *slack, *misfit, *rounding, *left, *right, *noise, *response, *unit;
    struct gb_enclosure *x, *enclosure, *torque, *bound, *kept;
    int *watched;
    int known, boxed, has_kept; /* of forces in these modes, see gb_force_enclosure.h (0: nothing); x is a box in which
                                   they stay inside, and so is kept, by so many steps */
    uint64_t known_modes;
};

struct gb_event_log {
    gb_event *event;
    long count, flushed, capacity;
};

/* The step matrix of an implicit method (GB_AUTO looks at it too). */
struct gb_implicit {
    double *diag, *inverse, *lower, *upper;   /* factors, see gb_sparse_ldu.h */
    double *kinematic_terms, *work, *unknown; /* what eliminates the kinematic states */
    int *colour, *link, n_colours; /* by unknown; by kinematic state and colour: the unknown in its rate, or -1 */
    double *gain, h;               /* and one over its factor; the step size that the matrix was made for */
    double *row_response, *row_inverse, *row_room; /* its answers to forces along active rows, inverse of their slips */
    double *row_change, *row_by_state;             /* of these slips: what unknowns and what states add */
    int tied, *tie_place;            /* active rows are ties, by step of the elimination as gb_ties has them, */
    double *tie_gain, *cluster_gain; /* and are all that is asked; how many times as fast as its cluster moves, */
    int *cluster;                    /* by speed, which cluster that is (-1: none) */
};

/* Switched constraints, by constraint; row_size, impacts, impact_speed in the block, all else scratch of an event. */
struct gb_constraints {
    double *row_size, *impacts, *impact_speed; /* sums of |G|; strikes so far, slips at powers of two of them (two) */
    double *row, *slip, *slip_rounding, *slip_before, *free_acceleration; /* row: rows of G over the speeds */
    double *bounds;                                                       /* five numbers each, see gb_model.h */
    double *delassus, *room;         /* W of all of them (see gb_delassus.h), and room for as much */
    double *right, *lo, *hi, *force; /* the complementarity problem of those that are in it */
    int *in;
    double *lo_slope, *hi_slope; /* what bounds grow by per force of another one, on[] (-1: they do not) */
    int *on;
    double *other, *force_before; /* forces or impulses of all; forces before the event */
    double *mode_before, *shrink, *full_mode;
    int *decision, *was_redundant, *released, *struck;
    int *was_broken, *broken; /* holds no more than what it carries while it slides: before and after the decision */
    double *peak;             /* what it holds before it breaks */
    const double *y;          /* the state by which it is decided */
    double fastest;           /* of the accelerations with no constraint active */
};

/* Lossy gears, by the constraint of their loss: what is decided without them; the sides that are assumed where they
 * slide forward and backward; what is tried. */
struct gb_lossy {
    double *base_mode;
    int *base_decision, *forward, *backward, *option;
};

struct gb_sim {
    const gb_model *model;
    const gb_method *method;
    void *memory;
    gb_head *head; /* the block begins here and has block_bytes */
    size_t block_bytes;

    /* In the block: */
    double *par, *y0, *y;
    double *k1;   /* the derivative at the front */
    double *rows; /* dense rows, each n_total long */
    double *mode; /* and behind them the active set; the block ends here */

    /* Outside the block. */
    double *k;             /* derivatives by stage, each n_total long */
    double *z, *z2, *zero; /* stage states, length n_total */

    gb_account *account; /* of a caller who asks, or NULL */
    struct gb_input_memory inputs;
    struct gb_control control;
    gb_lanes lanes, instant; /* of a step, of single instants */
    struct gb_events events;
    struct gb_unlocated unlocated;
    struct gb_sliding sliding;
    struct gb_panel panel;
    struct gb_event_log log;
    struct gb_constraints constraints;
    struct gb_lossy lossy;
    struct gb_implicit implicit;
    struct {
        double *rate, *inertia; /* by unknown, at the last look of GB_AUTO */
    } choice;
    struct {
        double *energies, *outputs, *inputs; /* of one instant */
        double *features;                    /* at the start, in the middle and at the end of a step */
    } scratch;
};

#endif
