/* What the generator writes and the solver reads: one train as a table of functions.
 *
 * The state vector y holds, in this order,
 *     [ coordinates q | states of blocks z | speeds v | padding | riders and ledger | padding ]
 * The first n entries move the train and are under error control. The tail follows
 * along: absolute angles that no law needs, then the energy integrals. Both parts are
 * padded with zeros to multiples of GB_PAD, so that whole vectors can be worked on.
 *
 * Branches are frozen: a law reads the mode of its switches, never their surfaces.
 * Only the event handler of the solver changes a mode.
 */
#ifndef GB_MODEL_H
#define GB_MODEL_H

enum {
    GB_LANES = 16, /* instants at which time columns are computed in one call */
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
 * outermost. Where every column has at most one entry (`tree`), there are no pairs. */
typedef struct gb_pattern {
    int n, n_places;
    int tree;
    const int *order, *start, *row, *pair;
} gb_pattern;

/* An angle among the states that no law can tell from itself less `turns` whole turns. The solver keeps it near zero;
 * the angle is y[state] + carry + 2 pi count, with the count and the carry (below the last digit of y) in the tail.
 * Each time `turns` are taken off, the mode of switches[j] (segments of periodic tables) falls by steps[j]. */
typedef struct gb_counted {
    int state, n_switches;
    double turns;
    const int *switches;
    const double *steps;
} gb_counted;

/* Friction that can stick, or a lock; a stop; a lossy tie and, as its partner, its loss. Its slip is a form of the
 * speeds; its switches: slip (mode: the direction in which it slides, 0 when stuck or free; of a stop its gap; of a tie
 * the sign of its force), hold (mode 1 while stuck or closed; quantity: by how much the held force exceeds its limits)
 * and free (mode 1 where it does not rub; -1: tell by its limits). impulse, impacts: states that keep the last impulse
 * and count (-1: none); loss: entry of y that counts what impacts lose. */
enum { GB_FRICTION, GB_STOP, GB_TIE, GB_LOSS };

typedef struct gb_lock {
    int kind, partner, slip, hold, free, impulse, impacts, loss;
} gb_lock;

struct gb_lock_rows;

typedef struct gb_model {
    const char *name;
    const char *key; /* hash of the canonical content */

    int n;            /* states under error control */
    int n_speeds;     /* the last of these are speeds (0: not known) */
    int n_padded;     /* n rounded up; the tail starts here */
    int n_tail;       /* riders and ledger integrals */
    int paced;        /* time alone moves shafts: the states do not tell how long a step may be */
    int n_angles;     /* the first entries of the tail that are angles or their turns; the others are energies */
    int n_total;      /* n_padded + n_tail, rounded up: length of y */
    int n_parameters; /* tunable values: par[0 .. n_parameters) */
    int n_par;        /* with the values derived from them: length of par */
    int n_inputs;
    int n_time; /* time columns */

    /* Switches: those with a surface affine in y come first, then other surfaces of the state,
     * then those that depend on time alone. */
    int n_affine;
    int n_surfaces; /* affine and general ones */
    int n_switches; /* with the time switches */

    int n_outputs;
    int n_energies;

    /* Fills par[n_parameters .. n_par) from par[0 .. n_parameters). */
    void (*prepare)(double *par);

    /* Start values from the parameters, length n_total (the ledger starts at zero); mode of time switches and tau
     * there. */
    void (*start)(const double *par, const double *mode, const double *tau, double *y);

    /* Natural size of each of the n states where the train knows one (gaps), else 0. */
    void (*scales)(const double *par, double *scale);

    /* Time columns at `lanes` instants t[]; u[input * GB_LANES + lane], tau[column * GB_LANES + lane].
     * t and u always hold GB_LANES valid entries (the last instant repeats): computing all is allowed. */
    void (*times)(const double *par, const double *mode, int lanes, const double *t, const double *u, double *tau);

    /* The same for columns that outputs and energies alone read, after times (NULL: there are none). */
    void (*times_late)(const double *par, const double *mode, int lanes, const double *t, const double *u, double *tau);

    /* dy/dt of the n states. tau points at the lane of this instant: column j is tau[j * GB_LANES]. */
    void (*rhs)(const double *par, const double *mode, const double *tau, const double *y, double *dy);

    /* The same, and the tail. */
    void (*rhs_full)(const double *par, const double *mode, const double *tau, const double *y, double *dy);

    /* Quantities of the switches [0, n_surfaces) at one instant. */
    void (*surfaces)(const double *par, const double *mode, const double *tau, const double *y, double *s);

    /* The linear part of the affine quantities [0, n_affine), applied to the direction dir (length n). */
    void (*directions)(const double *par, const double *dir, double *s);

    /* Limits of every switch in its mode: the mode is valid while lo <= quantity <= hi. */
    void (*bounds)(const double *par, const double *mode, double *lo, double *hi);

    /* The mode of switch i where its quantity is s (>= a limit belongs to the upper mode). */
    double (*mode_at)(const double *par, int i, double s);

    /* Changes the states of blocks that take a new value as the modes go from `before` to `mode` (NULL: there are
     * none). */
    void (*hold)(const double *par, const double *before, const double *mode, const double *tau, double *y);

    /* Quantity of time switch i (in [n_surfaces, n_switches)) at t, its modes as everywhere above. */
    double (*clock)(const double *par, int i, double t);

    /* The next instant > t at which time switch i leaves its mode (or HUGE_VAL), and the mode after it. */
    double (*next_time)(const double *par, int i, double mode, double t, double *after);

    /* All outputs; dy from rhs_full at the same point. */
    void (*outputs)(const double *par, const double *mode, const double *tau, const double *y, const double *dy,
                    double *out);

    /* Kinetic and stored energies, one per ledger entry. */
    void (*energies)(const double *par, const double *mode, const double *tau, const double *y, double *energy);

    /* What sticks (n_locks 0: nothing does). Behind the modes lie n_memory doubles that `remember` fills from them and
     * that every function with `mode` reads: which rows hold, see gb_constraint_rows.h. slips: of all locks, with dy
     * their rates; pulls: n_locks x n_locks, slip acceleration i per force j; grip: the row of one of them over the
     * speeds (with `force` what its force does to them); push: adds what impulses along the slips do to the speeds of
     * y; project: removes slips of what sticks; limits: five numbers per lock (least and largest held force, sizes of
     * the force against forward and backward slip, engagement; of a stop the third is its restitution); holding: held
     * forces, and by how much they exceed their limits. */
    int n_locks, n_memory;
    int steady_locks; /* their rows do not change with the position, and time moves none of them */
    const gb_lock *locks;
    const struct gb_lock_rows *lock_rows;
    void (*slips)(const double *par, const double *mode, const double *tau, const double *y, const double *dy,
                  double *slip);
    void (*pulls)(const double *par, const double *mode, const double *tau, const double *y, int lossy, double *matrix);
    void (*push)(const double *par, const double *mode, const double *tau, const double *impulse, double *y);
    void (*grip)(const double *par, const double *mode, const double *tau, const double *y, int i, int force,
                 double *row);
    void (*remember)(const double *par, double *mode, const double *tau, const double *y);
    void (*project)(const double *par, const double *mode, const double *tau, double *y);
    void (*limits)(const double *par, const double *mode, const double *tau, const double *y, double *limit);
    void (*holding)(const double *par, const double *mode, const double *tau, const double *y, double *held,
                    double *excess);

    /* NULL, or: puts the angles of shafts without inertia into balance (with `starting` at the start of a run). */
    void (*settle)(const double *par, const double *mode, const double *tau, double *y, int starting);

    /* For implicit methods (pattern NULL: there are none). The states are [ simple | others ]: the n_simple first ones
     * are coordinates and angles whose rates are fixed combinations of the others, y_s' = B x (where gains change with
     * the position, coordinates can be among the others, and E depends on the states). The unknowns are
     * x = [ y[n_simple .. n) | n_hidden speeds of shafts without inertia ], pattern->n in number.
     * With E x' = G(t, y) (E: inertia of the shafts, 1 for states of blocks, 0 for hidden speeds) the matrix of a step
     * is S = E - g dG/dx - g^2 dG/ds B,   g = gamma h, where d is that of G - E x' at fixed x'. jacobian: fills diag
     * (length pattern->n, by unknown), lower and upper (by place, factors not yet computed) and `kept` (length n_kept:
     * what the next two need). dy: the rates at the same point. right_side: out = E r_x + g dG/ds r_s for a right side
     * r of length n (hidden speeds: their rows alone). simple_rates: out[0 .. n_simple) = B x. */
    int n_simple, n_hidden, n_kept;
    const gb_pattern *pattern;
    void (*jacobian)(const double *par, const double *mode, const double *tau, const double *y, const double *dy,
                     double g, double *diag, double *lower, double *upper, double *kept);
    void (*right_side)(const double *par, const double *kept, double g, const double *r, double *out);
    void (*simple_rates)(const double *par, const double *kept, const double *x, double *out);

    /* As times for one lane, with every excitation by time alone at its mean (NULL: as they are). */
    void (*means)(const double *par, const double *mode, int lanes, const double *t, const double *u, double *tau);
    /* Angles whose turns are counted. Entries 2 c and 2 c + 1 of the tail belong to counted angle c. */
    int n_counted;
    const gb_counted *counted;
} gb_model;

#endif
