/* What the files of gb_fmu share. */
#ifndef GB_FMU_INTERNAL_H
#define GB_FMU_INTERNAL_H

#include "gb_fmu.h"
#include "gb_solver.h"

enum { GB_FMU_TOKEN = 64, GB_FMU_KIND_SHIFT = 24 };

/* Tolerances of the solver. */
#define GB_FMU_LEAST_RTOL 1e-14
#define GB_FMU_MOST_RTOL 0.1

/* What changes during a run beside the solver's own block. Saved and restored as it is. */
typedef struct gb_fmu_state {
    char token[GB_FMU_TOKEN];
    unsigned long long checksum; /* of a saved state: of all this and the start vector */
    gb_options options;
    double t_start, t;
    double t_asked; /* the last step was asked from here; before t where it stopped on its way */
    int phase;
    int started;  /* the solver holds the present start values */
    int own_rtol; /* the tolerance was set as a variable */
} gb_fmu_state;

struct gb_fmu {
    const gb_fmu_table *table;
    const gb_solver *solver;
    gb_sim *sim;
    gb_fmu_state s;
    int fresh;       /* outputs[] belongs to the present point and inputs */
    double *outputs; /* all outputs of the model */
    double *start;   /* start vector, where the states' start values are variables */
    char message[512];
};

int gb_fmu_refuse(gb_fmu *fmu, const char *format, ...); /* keeps the reason; always -1 */
double gb_fmu_clock(void);                               /* processor time of this thread [s] */
int gb_fmu_solver_failed(gb_fmu *fmu, int code);         /* names what, when and why; always -1 */
const char *gb_fmu_phase_words(int phase);

/* The solver starts from the values set so far; again when one of them changes before the end of the initialization. */
int gb_fmu_start(gb_fmu *fmu);

#endif
