/* Trains written by hand against gb_model.h, for the checks of the solver core. */
#ifndef MODELS_H
#define MODELS_H

#include "gb_core.h"

#include <math.h>

extern const gb_model p1_model, p2_model, relay_model, input_model, wave_model, ring_model, eight_model, growth_model,
    pol_model, node_model;
extern const double p1_values[3], p2_values[6];

/* A chain of n (even) inertias with values {n, swing, factor of the mesh stiffness}. */
gb_model *open_chain(int n);
void close_chain(gb_model *model);

#endif
