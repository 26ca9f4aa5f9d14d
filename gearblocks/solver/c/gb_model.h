/* What the generator writes and the solver reads: one train as a table of functions.
 *
 * The state vector y holds, in this order,
 *     [ relative coordinates q | states of blocks z | speeds v | padding | quadratures | padding ]
 * The first n entries move the train and are under error control. The quadratures are states that no law reads: counts
 * and carries of wrapped angles, absolute angles, then the energy integrals of the ledger. Both parts are padded with
 * zeros to multiples of GB_PAD, so that whole vectors can be worked on.
 *
 * Modes are frozen: a law reads the mode of its switches, never their event functions. Only the event handler of the
 * solver changes a mode.
 *
 * Time terms are what laws hoist out because it depends on time (and inputs and modes) alone.
 *
 * Knows nothing of methods and step sizes. */
#ifndef GB_MODEL_H
#define GB_MODEL_H

enum {
    GB_LANES = 16, /* instants at which time terms are computed in one call */
    GB_PAD = 8     /* doubles in one block of a padded vector */
};

/* One block of a padded vector. The same operations in the same order whatever the width of the machine's registers. */
typedef double gb_block __attribute__((vector_size(GB_PAD * sizeof(double)), aligned(sizeof(double)), may_alias));

/* A square sparse matrix with symmetric pattern, factored as L D U in a fixed order without pivoting.
 *
 * The unknown eliminated in step k is order[k]; column k of L has its entries in places [start[k], start[k + 1]), in
 * the rows row[place] > k (steps of the elimination, ascending). U has the transposed pattern and the same places.
 * Eliminating column k subtracts from the diagonal of each of its rows, and for every pair a < b of its entries from
 * the place pair[...] (of L at (row b, column row a), and of U transposed); pairs are listed column by column, a
 * outermost. Where every column has at most one entry (`tree`), there are no pairs. The unknowns of the first `ahead`
 * steps are read by no other equation: their columns of L are zero, and have no pairs. */
typedef struct gb_pattern {
    int n, n_places;
    int tree, ahead;
    const int *order, *start, *row, *pair;
} gb_pattern;

/* Angle wrapping: an angle among the states that no law can tell from itself less `turns` whole turns. The solver keeps
 * it near zero; unwrapped it is y[state] + carry + 2 pi count, with the wrap count and the carry (below the last digit
 * of y) among the quadratures. Each time `turns` are taken off, the mode of switches[j] (segments of periodic tables)
 * falls by steps[j]. */
typedef struct gb_wrapped {
    int state, n_switches;
    int speed; /* the state that is its rate, -1: none */
    double turns;
    const int *switches;
    const double *steps;
} gb_wrapped;

/* A switched constraint: a row G over the speeds, G v = 0 while it is active. Friction or an unbounded lock; a stop; a
 * lossy gear and, as its partner, its loss. Its switches: slip (event function G v, mode: the direction in which it
 * slides, 0 when stuck or free; of a stop its gap; of a lossy gear the sign of its force), active (mode 1 while stuck
 * or closed; event function: by how much the constraint force exceeds its bounds) and free (mode 1 where it is not
 * engaged; -1: its bounds tell). impulse, impacts: states that keep the last impulse and count (-1: none); loss: entry
 * of y that counts what impacts lose; heat: one more than the state that counts it as heat (0: none). */
enum { GB_FRICTION, GB_STOP, GB_TIE, GB_LOSS };

typedef struct gb_constraint {
    int kind, partner, slip, active, free, impulse, impacts, loss, heat;
} gb_constraint;

struct gb_constraint_rows;
struct gb_enclosure;

typedef struct gb_model {
    const char *name;
    const char *key; /* hash of the canonical content */

    int n;                  /* states under error control */
    int n_speeds;           /* the last of these are speeds (0: not known) */
    int n_padded;           /* n rounded up; the quadratures start here */
    int n_quadratures;      /* counts, angles and ledger integrals */
    int varying_inertia;    /* gains between shafts change with the position, and the inertias that they carry over */
    int prescribed_motion;  /* time alone moves shafts: the states do not tell how long a step may be */
    int n_angles;           /* the first quadratures that are angles or wrap counts; the others are energies */
    const int *angle_speed; /* by angle among them: the state that is its rate, -1: none; NULL: they are wrap counts */
    int n_total;            /* n_padded + n_quadratures, rounded up: length of y */
    int n_parameters;       /* tunable values: par[0 .. n_parameters) */
    int n_par;              /* with the values derived from them: length of par */
    int n_inputs;
    int n_time_terms;

    /* Switches: those whose event function is affine in y come first, then other functions of the state,
     * then those that depend on time alone. */
    int n_affine;
    int n_event_functions; /* affine and general ones */
    int n_switches;        /* with the time switches */

    int n_outputs;
    int n_energies;

    /* Fills par[n_parameters .. n_par) from par[0 .. n_parameters). */
    void (*prepare)(double *par);

    /* Start values from the parameters, length n_total (the ledger starts at zero); mode of time switches and time
     * terms there. */
    void (*start)(const double *par, const double *mode, const double *time_terms, double *y);

    /* Natural size of each of the n states where the train knows one (gaps), else 0. */
    void (*scales)(const double *par, double *scale);

    /* Time terms at `lanes` instants t[]; u[input * GB_LANES + lane], time_terms[term * GB_LANES + lane].
     * t and u always hold GB_LANES valid entries (the last instant repeats): computing all is allowed. */
    void (*time_terms)(const double *par, const double *mode, int lanes, const double *t, const double *u,
                       double *time_terms);

    /* The same for terms that outputs and energies alone read, after time_terms (NULL: there are none). */
    void (*output_time_terms)(const double *par, const double *mode, int lanes, const double *t, const double *u,
                              double *time_terms);

    /* dy/dt of the n states. time_terms points at the lane of this instant: term j is time_terms[j * GB_LANES]. */
    void (*rhs)(const double *par, const double *mode, const double *time_terms, const double *y, double *dy);

    /* The same, and the quadratures. */
    void (*rhs_full)(const double *par, const double *mode, const double *time_terms, const double *y, double *dy);

    /* Event functions of the switches [0, n_event_functions) at one instant. */
    void (*event_functions)(const double *par, const double *mode, const double *time_terms, const double *y,
                            double *s);

    /* Enclosures (n_arguments 0: there are none): event functions as functions of n_arguments quantities x that move as
     * smoothly as the solution: t, the inputs, then what `arguments` fills in at a point (it leaves t and inputs
     * alone). enclosures: event functions over a piece of a step, from x over it, of those with is_enclosed[i -
     * n_affine]; they read the x named in arguments_read. */
    int n_arguments, n_arguments_read;
    const int *arguments_read, *is_enclosed;
    void (*arguments)(const double *par, const double *mode, const double *time_terms, const double *y, double *x);
    void (*enclosures)(const double *par, const double *mode, const struct gb_enclosure *x, struct gb_enclosure *s);

    /* NULL, or: constraint forces are a linear function of torques on n_groups groups (those of states and inputs, over
     * a piece of a step, with the force bounds: lower and upper of each constraint). forces_of_torques changes torque.
     */
    int n_groups;
    void (*force_enclosures)(const double *par, const double *mode, const struct gb_enclosure *x,
                             struct gb_enclosure *torque, struct gb_enclosure *bound);
    void (*forces_of_torques)(const double *par, const double *mode, double *torque, double *force);

    /* The linear part of the affine event functions [0, n_affine), applied to the direction dir (length n). */
    void (*directions)(const double *par, const double *dir, double *s);

    /* Limits of every switch in its mode: the mode is valid while lo <= event function <= hi. */
    void (*mode_limits)(const double *par, const double *mode, double *lo, double *hi);

    /* The mode of switch i where its event function is s. A limit belongs to the upper mode, but 0 of a strict
     * condition. exact_switches: those of which it is asked how they are where s stays on a limit, first all that time
     * and inputs alone move. */
    double (*mode_at)(const double *par, int i, double s);
    int n_exact_timed, n_exact_switches;
    const int *exact_switches;

    /* Changes the states of blocks that take a new value as the modes go from `before` to `mode` (NULL: there are
     * none). n_inverse_speeds of them are one over a speed, set by a switch. */
    void (*update_states)(const double *par, const double *before, const double *mode, const double *time_terms,
                          double *y);
    int n_inverse_speeds;
    const int *inverse_speeds, *inverse_speed_switches;

    /* Narrow features: arguments x of functions that are flat but for a part of their range, in widths of that part;
     * bounded: flat where abs(x) is large, else they go on periodically (n_features 0: there are none). */
    int n_features;
    const int *bounded_feature;
    void (*features)(const double *par, const double *mode, const double *time_terms, const double *y, double *feature);

    /* Event function of time switch i (in [n_event_functions, n_switches)) at t, or a number on its side just after t;
     * its modes as everywhere above. */
    double (*time_function)(const double *par, int i, double t);

    /* The next instant > t at which time switch i leaves its mode (or HUGE_VAL), and the mode after it. */
    double (*next_time)(const double *par, int i, double mode, double t, double *after);

    /* All outputs; dy from rhs_full at the same point. */
    void (*outputs)(const double *par, const double *mode, const double *time_terms, const double *y, const double *dy,
                    double *out);

    /* NULL, or: outputs first .. last alone where these follow from the state, without dy; answers whether they do. */
    int (*outputs_of_state)(const double *par, const double *mode, const double *time_terms, const double *y, int first,
                            int last, double *out);

    /* NULL, or: outputs first .. last, as `outputs`. Both functions may leave others as they are. */
    void (*some_outputs)(const double *par, const double *mode, const double *time_terms, const double *y,
                         const double *dy, int first, int last, double *out);

    /* Kinetic and stored energies, one per ledger entry. */
    const signed char *energy_sign; /* of the integrals behind those of angles: 1 lost, -1 supplied */
    void (*energies)(const double *par, const double *mode, const double *time_terms, const double *y, double *energy);

    /* Switched constraints G v + g(t) = 0 (n_constraints 0: none). Behind the modes lie n_active_set doubles, the
     * active set, and behind them what follows from it (see gb_constraint_rows.h). factor_active_set fills both from
     * the modes, renew_active_set the second part from the first; every function with `mode` reads them. slips: G v + g
     * of all, with dy its rates; delassus: W = G M^-1 G' as in gb_delassus.h (with `lossy`: with what lossy gears lose
     * of the force); constraint_row: row i over the speeds (with `force`: what its force does to them);
     * apply_impulses: adds to the speeds of y what impulses along the rows do; project_velocities: removes slips of
     * active constraints; force_bounds: five numbers per constraint (least and largest constraint force, sizes of the
     * force against forward and backward slip, engagement; of a stop the third is its restitution); constraint_forces:
     * these, and by how much they exceed their bounds. slip_switches: segments of tables over abs(slip). */
    int n_constraints, n_active_set;
    int constant_rows; /* they do not change with the position, and time moves none of them */
    int driven_rows;   /* time moves some of them: what they hold need not be at rest */
    int n_slip_switches;
    const int *slip_switches;
    const gb_constraint *constraints;
    const struct gb_constraint_rows *constraint_rows;
    void (*slips)(const double *par, const double *mode, const double *time_terms, const double *y, const double *dy,
                  double *slip);
    void (*delassus)(const double *par, const double *mode, const double *time_terms, const double *y, int lossy,
                     double *matrix);
    void (*apply_impulses)(const double *par, const double *mode, const double *time_terms, const double *impulse,
                           double *y);
    void (*constraint_row)(const double *par, const double *mode, const double *time_terms, const double *y, int i,
                           int force, double *row);
    void (*factor_active_set)(const double *par, double *mode, const double *time_terms, const double *y);
    void (*renew_active_set)(const double *par, double *mode);
    void (*project_velocities)(const double *par, const double *mode, const double *time_terms, double *y);
    void (*force_bounds)(const double *par, const double *mode, const double *time_terms, const double *y,
                         double *bounds);
    void (*constraint_forces)(const double *par, const double *mode, const double *time_terms, const double *y,
                              double *force, double *violation);

    /* NULL, or: puts the angles of massless groups into balance (with `starting` at the start of a run). */
    void (*balance_massless)(const double *par, const double *mode, const double *time_terms, double *y, int starting);
    /* NULL, or: how many massless groups beside friction springs alone hold in these modes. */
    int (*springs_alone)(const double *par, const double *mode, const double *time_terms, const double *y);

    /* For implicit methods (pattern NULL: there are none). The states are [ kinematic | others ]: the n_kinematic first
     * ones are coordinates and angles whose rates are fixed combinations of the others, y_s' = B x (where gains change
     * with the position, coordinates can be among the others, and E depends on the states). The unknowns are
     * x = [ y[n_kinematic .. n) | n_massless speeds of massless groups ], pattern->n in number.
     * With E x' = G(t, y) (E: inertia of the groups, 1 for states of blocks, 0 for massless speeds) the step matrix is
     * S = E - g dG/dx - g^2 dG/ds B,   g = gamma h, where d is that of G - E x' at fixed x'. step_matrix: fills diag
     * (length pattern->n, by unknown), lower and upper (by place, factors not yet computed) and kinematic_terms (length
     * n_kinematic_terms: what the next two need). dy: the rates at the same point. right_side: out = E r_x + g dG/ds
     * r_s for a right side r of length n (massless speeds: their rows alone). kinematic_rates: out[0 .. n_kinematic) =
     * B x. constraint_change (NULL: only speeds do): with the kinematic_terms of a step matrix, what the unknowns add
     * to the slip of constraint i besides its row, and what the y before the speeds of a right side do. */
    int n_kinematic, n_massless, n_kinematic_terms;
    const gb_pattern *pattern;
    void (*step_matrix)(const double *par, const double *mode, const double *time_terms, const double *y,
                        const double *dy, double g, double *diag, double *lower, double *upper,
                        double *kinematic_terms);
    void (*right_side)(const double *par, const double *kinematic_terms, double g, const double *r, double *out);
    void (*kinematic_rates)(const double *par, const double *kinematic_terms, const double *x, double *out);
    void (*constraint_change)(const double *kinematic_terms, int i, double *unknowns, double *states);
    /* NULL, or: adds to the rates of the unknowns what a force of constraint i heats. */
    void (*heat_of_force)(const double *par, const double *mode, const double *time_terms, const double *y, int i,
                          double force, double *unknowns);

    /* As time_terms for one lane, with every excitation by time alone at its mean (NULL: as they are). */
    void (*mean_time_terms)(const double *par, const double *mode, int lanes, const double *t, const double *u,
                            double *time_terms);
    /* The same with sizes of which rounding is a part, of those terms that are sums (NULL: none are). */
    void (*time_term_sizes)(const double *par, const double *mode, int lanes, const double *t, const double *u,
                            double *time_terms);
    /* Wrapped angles. Quadratures 2 c and 2 c + 1 are count and carry of wrapped angle c. */
    int n_wrapped;
    const gb_wrapped *wrapped;
} gb_model;

#endif
