/* One instance of a packed train: variables by reference, life cycle, stepping, saved states.
 *
 * Independent of the FMI version; the glue of a version (fmi2_glue.c) translates names, types and states and logs.
 * Every function that returns int answers 0, or -1 with the reason in gb_fmu_message; a positive answer comes with a
 * message too.
 *
 * A reference is kind * 2^24 + position among the entries of its kind.
 */
#ifndef GB_FMU_H
#define GB_FMU_H

#include "gb_core.h"

enum {
    GB_FMU_SOLVER = 0,
    GB_FMU_PARAMETER = 1,
    GB_FMU_INPUT = 2,
    GB_FMU_OUTPUT = 3,
    GB_FMU_START = 4,
    GB_FMU_KINDS = 5
};

/* What `index` means among the entries of kind GB_FMU_SOLVER. */
enum { GB_FMU_TIME = 0, GB_FMU_RTOL = 1, GB_FMU_STEP = 2 };

typedef struct gb_fmu_entry {
    const char *name;
    int index;   /* position in the model's vector of that kind */
    int tunable; /* may be set while the model runs */
    double start, lower, upper;
    int open_lower, open_upper; /* the bound itself is no value of it */
} gb_fmu_entry;

/* A quadrature of the model: an angle or an energy that no law reads. */
typedef struct gb_fmu_quadrature {
    const char *name;
    int index; /* in the state vector */
} gb_fmu_quadrature;

/* Written by the exporter for one model. */
typedef struct gb_fmu_table {
    const char *token; /* hash of the canonical content, 64 characters */
    int method, locate;
    double max_step;
    double patience; /* processor time [s] after which a step stops on its way; HUGE_VAL: none */
    int count[GB_FMU_KINDS];
    const gb_fmu_entry *entries[GB_FMU_KINDS];
    int n_states, n_quadratures, n_switches;
    const char *const *states; /* names of the states, and behind them of the massless speeds */
    const gb_fmu_quadrature *quadratures;
    const char *const *switches; /* names of the switches */
} gb_fmu_table;

extern const gb_fmu_table gb_fmu_the_table;

/* Where an instance stands. */
enum { GB_FMU_NEW, GB_FMU_INITIALIZING, GB_FMU_RUNNING, GB_FMU_ENDED, GB_FMU_FAILED };

typedef struct gb_fmu gb_fmu;

const char *gb_fmu_missing(void); /* why there can be no instance here, NULL where there can */
gb_fmu *gb_fmu_open(void);        /* NULL: no memory */
void gb_fmu_close(gb_fmu *fmu);
const char *gb_fmu_message(const gb_fmu *fmu);
double gb_fmu_time(const gb_fmu *fmu);
long long gb_fmu_events(const gb_fmu *fmu); /* located so far */

/* NULL: not given. A tolerance that was set as a variable stays. 1: the one given is out of range, another is taken. */
int gb_fmu_setup(gb_fmu *fmu, double start, const double *stop, const double *rtol);
int gb_fmu_initialize(gb_fmu *fmu);
int gb_fmu_begin(gb_fmu *fmu);
/* 1: it would take longer than the table's patience, and stands at gb_fmu_time. It goes on where it is asked for again,
 * or for a step from there, with the bits of one step. */
int gb_fmu_step(gb_fmu *fmu, double t, double h);
int gb_fmu_end(gb_fmu *fmu);
int gb_fmu_reset(gb_fmu *fmu);

/* Nothing is set when one of the values is refused. */
int gb_fmu_get(gb_fmu *fmu, const unsigned *refs, size_t n, double *values);
int gb_fmu_set(gb_fmu *fmu, const unsigned *refs, size_t n, const double *values);

/* A saved state is one block without pointers that another process may restore. It carries checksums: one that is of
 * another model, or damaged, is refused. */
size_t gb_fmu_block_size(const gb_fmu *fmu);
void gb_fmu_save(const gb_fmu *fmu, void *block);
int gb_fmu_fits(gb_fmu *fmu, const void *block, size_t size);
int gb_fmu_restore(gb_fmu *fmu, const void *block);

#endif
