/* What the checks of the solver core share. */
#ifndef CHECKS_H
#define CHECKS_H

#include "models.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_EVENTS = 4096, ROW = 1 + 16 + 1 + 1 };

/* A run with its record: rows of [t | y (16) | mode or input ...]. */
typedef struct run {
    gb_sim *sim;
    gb_record record;
    int code;
} run;

extern int failures;

#define CHECK(condition, ...)                                                                                          \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            failures++;                                                                                                \
            printf("FAILED %s:%d: %s: ", __FILE__, __LINE__, #condition);                                              \
            printf(__VA_ARGS__);                                                                                       \
            printf("\n");                                                                                              \
        }                                                                                                              \
    } while (0)

gb_options options_of(int method, double rtol, double step);
gb_sim *open_model(const gb_model *model, const double *values, const gb_options *options, int *code);
size_t row_length(const gb_model *model);
run run_samples(const gb_model *model, const double *values, gb_options options, const double *t, long n);
run run_steps(const gb_model *model, const double *values, gb_options options, double t_end, long capacity);
void free_run(run *r);
void grid(double *t, long n, double t_end);
double largest_error(const run *r, const run *reference, int state);

void check_accuracy(void);
void check_events(void);
void check_inputs(void);
void check_state(void);
void check_hard(void);
void check_math(void);
void check_stiff(void);
void check_tangents(void);

#endif
