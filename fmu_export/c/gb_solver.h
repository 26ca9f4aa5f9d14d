/* The solver and the model as a table of calls. A binary may hold them several times, each made for another kind of
 * processor, of which the one that this processor can run best is taken. All of them give the same bits.
 * Knows nothing of instances and variables. */
#ifndef GB_SOLVER_H
#define GB_SOLVER_H

#include "gb_core.h"

const gb_model *gb_get_model(void);

/* The calls of gb_core.h by their names. */
typedef struct gb_solver {
    const gb_model *(*get_model)(void);
    gb_sim *(*open)(const gb_model *model);
    void (*close)(gb_sim *sim);
    const gb_model *(*model_of)(const gb_sim *sim);
    double *(*parameters)(gb_sim *sim);
    double *(*inputs)(gb_sim *sim);
    void (*changed)(gb_sim *sim);
    int (*start)(gb_sim *sim, const gb_options *options, double t0, const double *y0);
    int (*advance_within)(gb_sim *sim, double t, long moves);
    double (*time)(const gb_sim *sim);
    int (*outputs)(gb_sim *sim, double *out);
    size_t (*snapshot_size)(const gb_sim *sim);
    void (*save)(const gb_sim *sim, void *block);
    int (*fits)(const gb_sim *sim, const void *block);
    int (*restore)(gb_sim *sim, const void *block);
    unsigned long long (*checksum)(const void *bytes, size_t count, unsigned long long seed);
    void (*get_stats)(const gb_sim *sim, gb_stats *stats);
    void (*get_report)(const gb_sim *sim, gb_report *report);
} gb_solver;

/* The one for any processor, or the only one. */
extern const gb_solver gb_solver_plain;

/* The one to take: the environment variable GEARBLOCKS_VARIANT names it, else the best that this processor can run.
 * NULL where it names none that is here and can be run. */
const gb_solver *gb_solver_here(void);

/* What then is wrong, and which there are. */
const char *gb_solver_words(void);

#endif
