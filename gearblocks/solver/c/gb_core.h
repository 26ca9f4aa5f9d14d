/* The solver: open, start, advance, close. The same code runs in-process and inside every FMU.
 *
 * No globals, no allocation after gb_open. Everything that changes during a run lies in one block of memory without
 * pointers, so that saving the state is one copy.
 * Knows nothing of blocks and trains. */
#ifndef GB_CORE_H
#define GB_CORE_H

#include "gb_model.h"

#include <stddef.h>

/* What a shared library with hidden names shows. Define it empty to show nothing. */
#ifndef GB_API
#if defined(_WIN32)
#define GB_API __declspec(dllexport)
#else
#define GB_API __attribute__((visibility("default")))
#endif
#endif

typedef struct gb_sim gb_sim;

/* What a call answers. Negative: the run cannot go on; gb_report says where and why. */
enum {
    GB_DONE = 0,           /* reached the time asked for */
    GB_FULL = 1,           /* the record is full: empty it and call again */
    GB_PAUSE = 2,          /* the time slice is over: call again */
    GB_ERR_STEP = -1,      /* step size below rounding; index: the state with the largest error */
    GB_ERR_NAN_RATE = -2,  /* a derivative is NaN or infinite; index: entry of y */
    GB_ERR_NAN_INPUT = -3, /* an input is NaN or infinite; index: input */
    GB_ERR_NAN_START = -4, /* a start value or parameter is NaN or infinite; index: state or n + parameter */
    GB_ERR_CHATTER = -5,   /* a switch flips without progress; index: switch */
    GB_ERR_BRANCH = -6,    /* no consistent set of modes after an event; index: switch */
    GB_ERR_STATE = -7,     /* a saved state of another model or size, or a damaged one */
    GB_ERR_MEMORY = -8,
    GB_ERR_CALLBACK = -9,  /* the input callback asked to stop; index: input */
    GB_ERR_SINGULAR = -10, /* the step matrix has no inverse; index: state (from n on: massless speed) */
    GB_ERR_METHOD = -11,   /* the model has no Jacobian for this method; index: method */
    GB_ERR_LOSS = -12,     /* no motion fits the losses of a lossy gear, or (value) 2 at the start; index: switch */
    GB_ERR_BEYOND = -13,   /* the start lies beyond a stop, or breaks a lossy gear; index: switch */
    GB_ERR_UNSTABLE = -14, /* fixed steps (value) outside the stability of the method; index: state */
    GB_ERR_ESCAPE = -15,   /* motion that grows without bound; index: the state that grows quickest, or -1 */
    GB_ERR_JUMP = -16,     /* a spring that friction alone loads would jump; index: state */
    GB_ERR_STALL = -17     /* steps or refused tries (value) without progress; index: state or n + switch */
};

/* GB_AUTO: order 8 (order 5 above a tolerance of 1e-3), and the implicit method while the train is stiff. */
enum { GB_RK4 = 0, GB_DP5 = 1, GB_DP8 = 2, GB_RODAS = 3, GB_METHODS = 4, GB_AUTO = 4 };

typedef struct gb_options {
    int method;      /* GB_RK4 .. GB_AUTO */
    int locate;      /* 1: switches are located; 0: each stage has its own modes, constraints switch at step ends */
    double rtol;     /* relative tolerance of the step control */
    double step;     /* > 0: fixed steps on the grid t_start + i step (events in between), else adaptive */
    double max_step; /* largest adaptive step, HUGE_VAL: none */
    double t_stop;   /* no step reaches beyond, HUGE_VAL: none */
} gb_options;

/* Sources of inputs. The default is a constant. */
enum { GB_CONSTANT = 0, GB_LINEAR = 1, GB_STEP = 2, GB_CUBIC = 3, GB_CALLBACK = 4 };

/* Value of input `index` at t; returns 0, or non-zero to stop the run with GB_ERR_CALLBACK. */
typedef int (*gb_input_fn)(void *user, int index, double t, double *value);

enum { GB_KEPT = 8 };

/* Counters of a run. */
typedef struct gb_stats {
    double t;        /* front of the solver */
    double step;     /* size of the next step */
    double turnover; /* sum over steps and ledger entries of abs(exchange) */
    long long steps, rejected, rhs_calls, events, jacobians;
    long long steps_by[GB_METHODS]; /* steps of each method */
    int method;                     /* that of the next step */
    int n_switches;                 /* changes of the method by GB_AUTO; the first ones and the last one are kept */
    int switch_method[GB_KEPT];
    double switch_t[GB_KEPT];
} gb_stats;

typedef struct gb_report {
    int code, index;
    double t, value;
} gb_report;

/* One event: switch `index` (>= n_switches: a jump of the stepped table of input index - n_switches). */
typedef struct gb_event {
    double t, before, after;
    int index, kind; /* kind 0: state, 1: time */
} gb_event;

/* What is kept of an output along a run: its largest or least value, its mean, root mean square or standard deviation
 * over time [after, before]. */
enum { GB_PEAK = 0, GB_TROUGH = 1, GB_MEAN = 2, GB_RMS = 3, GB_STD = 4 };

typedef struct gb_quantity {
    int kind;
    double after, before, value;
    double sum, rest, scale, length;
} gb_quantity;

/* Several of them, the output of each and another one that it is multiplied by (-1: none). room:
 * gb_quantity_room(sim, count) numbers of the caller's. follows: the front has been looked at from the segment before.
 */
typedef struct gb_quantities {
    gb_quantity *of;
    const int *output, *factor;
    int count, follows;
    double *room;
} gb_quantities;

/* What is watched of an output along the steps of a run: how often its size comes to exceed a limit, or, with the limit
 * 0, how often its sign changes; when first (NAN: never); its least and largest value. Behind: its last side of the
 * limits, and when and where it was there; the size from which on signs are told from errors; the values between which
 * nothing is to be told; its last value. */
typedef struct gb_watch {
    double limit;
    long long count;
    double first, least, largest;
    int side;
    double t, value, known, low, high, seen;
} gb_watch;

/* Several of them, and the output of each. room: gb_watch_room(sim, count) numbers of the caller's. */
typedef struct gb_watches {
    gb_watch *of;
    const int *output;
    int count, from_event;
    double *room;
} gb_watches;

/* What limited the steps that were accepted and those that were not: the error of a state, of massless groups, of the
 * energy ledger, of the energy balance, of the dense polynomial; motion too fast for the method; narrow features of
 * laws; turns of a wrapped angle; the largest or the fixed step; an event in the step; event functions that a step does
 * not tell; an announced time; a rate that is no number. By state, n each, how often the state with the largest error.
 * Behind: what is known of the step under way. */
enum {
    GB_BY_STATE,
    GB_BY_MASSLESS,
    GB_BY_LEDGER,
    GB_BY_BALANCE,
    GB_BY_DEFECT,
    GB_BY_REACH,
    GB_BY_FEATURE,
    GB_BY_TURN,
    GB_BY_MOST,
    GB_BY_EVENT,
    GB_BY_DOUBT,
    GB_BY_TIME,
    GB_BY_FAILURE,
    GB_CAUSES
};

typedef struct gb_account {
    long long accepted[GB_CAUSES], rejected[GB_CAUSES];
    long long *accepted_by, *rejected_by;
    int size, cause;
} gb_account;

/* A record that the caller owns. A row is [t | y (n_total) | modes (n_switches) | inputs (n_inputs)]. */
typedef struct gb_record {
    double *rows;
    long n_rows, row_capacity;
    gb_event *events;
    long n_events, event_capacity;
    gb_quantities *quantities; /* or NULL */
    gb_watches *watches;       /* or NULL */
} gb_record;

GB_API gb_sim *gb_open(const gb_model *model);
GB_API void gb_close(gb_sim *sim);
GB_API const gb_model *gb_model_of(const gb_sim *sim);

/* Values. A change of a parameter or input during a run takes effect at the present communication point:
 * the next gb_advance restarts from the interpolated state there. */
GB_API double *gb_parameters(gb_sim *sim); /* length n_parameters; call gb_changed after writing */
GB_API double *gb_inputs(gb_sim *sim);     /* constant values, length n_inputs; call gb_changed after writing */
GB_API void gb_changed(gb_sim *sim);
/* The table is kept by the caller until gb_close; y2: second derivatives for GB_CUBIC; period 0: held outside. */
GB_API int gb_input_table(gb_sim *sim, int input, int kind, int points, const double *x, const double *y,
                          const double *y2, double period);
GB_API void gb_input_callback(gb_sim *sim, int input, gb_input_fn fn, void *user);

/* Start: model->prepare and model->start, overridden by y0 where it is not NULL (length n_total), then modes at t0. */
GB_API int gb_start(gb_sim *sim, const gb_options *options, double t0, const double *y0);

/* FMU style: advance to t (>= the last one) and hold there. The solver's own step goes on across calls. */
GB_API int gb_advance(gb_sim *sim, double t);
/* The same with at most so many steps and events, failing which the communication point is the front and the answer
 * GB_PAUSE: the next call goes on from there with the bits of one call. */
GB_API int gb_advance_within(gb_sim *sim, double t, long moves);
GB_API double gb_time(const gb_sim *sim);            /* the present communication point */
GB_API int gb_state(gb_sim *sim, double *y);         /* interpolated there */
GB_API int gb_outputs(gb_sim *sim, double *out);     /* all outputs there, length n_outputs */
GB_API int gb_energies(gb_sim *sim, double *energy); /* length n_energies */
/* Where all motion so far is rounding of forces that balance: an energy that nothing can be told of; else 0. */
GB_API double gb_rounding_energy(gb_sim *sim);

/* In-process style: run through the samples t_out[0 .. n_out), or record every accepted step up to t_end with both
 * sides of each event when t_out is NULL. Returns about every `slice` CPU seconds. */
GB_API int gb_run(gb_sim *sim, const double *t_out, long n_out, double t_end, gb_record *record, double slice);

/* Outputs of recorded rows: out[row * n_pick + j] = output pick[j]; energies likewise when energy is not NULL. The rows
 * may be of any run with these parameters; none needs to have been started here. */
GB_API int gb_evaluate(gb_sim *sim, const double *rows, long n_rows, const int *pick, int n_pick, double *out,
                       double *energy);

/* How many numbers of room quantities need. */
GB_API size_t gb_quantity_room(const gb_sim *sim, int count);

/* Counts from here on what limits the steps, until NULL is given. */
GB_API void gb_keep_account(gb_sim *sim, gb_account *account);

/* How many numbers of room watches need; before a run (limits stand). */
GB_API size_t gb_watch_room(const gb_sim *sim, int count);
GB_API void gb_watches_begin(gb_watches *all);

/* Many runs of one model. By point: parameters; inputs, start (length n_total) and steps, where these are not NULL (a
 * lone_start is that of every point); times, rising, of which the last one is the end; windows [after, before] of the
 * quantities. What is found, by point: values, at each time the outputs and then the states that are asked for;
 * start_states; quantities; balance: the energy at the begin and at the end, what came in between, sum of
 * sign[i] (y_end - y_begin)[ledger[i]], and the turnover; events: how many there were up to its end, at all points. */
typedef struct gb_study {
    long n_points, point; /* the one under way */
    int begun, lone_start;
    gb_options options;
    double t0;
    const double *parameters, *inputs, *start, *steps, *times, *windows;
    const int *outputs, *states, *ledger;
    const double *sign;
    long n_times;
    int n_outputs, n_states, n_ledger;
    gb_record record;       /* room for at least one row, and events of all points since it was emptied */
    double *first;          /* room for n_total numbers */
    long n_done;            /* times of the point that are done with */
    long long events_taken; /* out of the record, by the caller */
    double *values, *start_states, *quantities, *balance;
    long long *events;
} gb_study;

/* Goes on with the points for about `slice` CPU seconds. GB_FULL: the events fill the record, empty it. Below zero: the
 * point cannot be run (gb_get_report); it goes on with the next one as `point` and begun = 0. */
GB_API int gb_study_run(gb_sim *sim, gb_study *study, double slice);

/* Tangents beside a run from its start on: `count` columns of dy/dy0 over the n states, n_total numbers each, those
 * behind n zeros. times, rising: where steps end and, by time, what is not NULL is written: the state (n_total) into
 * states, the columns into maps; with logs the columns are made orthonormal there (in units of `scale`, by state), to
 * the n_fixed orthonormal directions in `fixed` too, and the logarithms of what they were as long as go into logs.
 * change (NULL: none): derivatives of the parameters (n_parameters) along which the last column goes, that of the state
 * by them; without logs. done: times that are done with. undefined: events without a derivative so far, the first of
 * which was that of switch `index` at t. Behind: what is known of the event under way. room: gb_tangent_size numbers of
 * the caller's. */
typedef struct gb_tangents {
    int count, n_fixed, index;
    long n_times, done;
    long long undefined;
    double t;
    const double *times, *scale, *fixed, *change;
    double *columns, *states, *maps, *logs, *room;
    int doubt, surface;
} gb_tangents;

GB_API size_t gb_tangent_size(const gb_sim *sim, int count);

/* Goes on through the times for about `slice` CPU seconds, with explicit methods and located events. */
GB_API int gb_tangents_run(gb_sim *sim, gb_tangents *tangents, double slice);

/* One evaluation of the right-hand side at (t, y, modes of the sim), for tests: dy has length n_total. */
GB_API int gb_rhs(gb_sim *sim, double t, const double *y, double *dy);

/* A point to look at. mode: of all switches (length n_switches), or NULL: those of the sim; input: values of all
 * inputs, or NULL: as their sources have them at t; means: every excitation by time alone at its mean
 * (gb_model.mean_time_terms); rate: rates (length n_total) that the outputs take as given, or NULL: those of the laws.
 */
typedef struct gb_point {
    double t;
    int means;
    const double *mode, *input, *rate;
} gb_point;

/* Step matrix, for tests and tools: see step_matrix, right_side and kinematic_rates of gb_model, at a point. No pattern
 * (NULL): the model has none, and the calls answer GB_ERR_STATE. */
GB_API const gb_pattern *gb_pattern_of(const gb_sim *sim);
GB_API void gb_step_matrix_sizes(const gb_sim *sim, int *n_kinematic, int *n_massless, int *n_kinematic_terms);
GB_API int gb_step_matrix_at(gb_sim *sim, const gb_point *at, const double *y, double g, double *diag, double *lower,
                             double *upper, double *kinematic_terms);
GB_API int gb_step_matrix_right_side(const gb_sim *sim, const double *kinematic_terms, double g, const double *r,
                                     double *out);
GB_API int gb_kinematic_rates(const gb_sim *sim, const double *kinematic_terms, const double *x, double *out);

/* Switched constraints, for tools. gb_constraints_of: how many there are; number of speeds; whether rows never change;
 * kind and slip, active and free switches of each, four numbers (index NULL: not wanted). gb_modes: the present modes
 * of all switches. gb_constraints_at: at a point, rows G over the speeds (n_constraints times n_speeds) and what a
 * force does to these, force bounds (five numbers each, see gb_model.h), constraint forces, by how much these exceed
 * their bounds, and the event functions of the slip switches. */
GB_API int gb_constraints_of(const gb_sim *sim, int *n_speeds, int *steady, int *index);
GB_API int gb_modes(const gb_sim *sim, double *mode);
GB_API int gb_constraints_at(gb_sim *sim, const gb_point *at, const double *y, double *rows, double *effects,
                             double *bounds, double *force, double *violation, double *slip);

/* The laws at a point, into what is not NULL: dy (length n_total), all outputs, all energies, `fit`, the modes that
 * fit state and time there, and the event functions of the switches that are not of time alone (length n_switches).
 * Needs gb_start for the values derived from parameters, which may have failed where modes are given; changes nothing
 * of the run. */
GB_API int gb_probe(gb_sim *sim, const gb_point *at, const double *y, double *dy, double *out, double *energy,
                    double *fit, double *surface);

/* The whole changing state as one block. gb_fits: whether it was saved by this model and is as it was; gb_restore
 * answers GB_ERR_STATE for any other. gb_checksum: of any bytes. */
GB_API size_t gb_snapshot_size(const gb_sim *sim);
GB_API void gb_save(const gb_sim *sim, void *block);
GB_API int gb_fits(const gb_sim *sim, const void *block);
GB_API int gb_restore(gb_sim *sim, const void *block);
GB_API unsigned long long gb_checksum(const void *bytes, size_t count, unsigned long long seed);

GB_API void gb_get_stats(const gb_sim *sim, gb_stats *stats);
GB_API void gb_get_report(const gb_sim *sim, gb_report *report);

#endif
