/* Derivatives by the parameters along `change` (gb_tangents of gb_core.h): rates, event functions less their limits,
 * and instants of time switches, as differences of fourth order between trains with other parameters at one state, in
 * the modes of the run. Knows nothing of columns. */
#ifndef GB_TANGENT_PARAMETER_H
#define GB_TANGENT_PARAMETER_H

#include "gb_tangent_room.h"

static const double GB_PARAMETER_REACH = 2e-5; /* of the change: distance between the points of a difference */

/* The parameters of the points of a difference, into room->par. */
void gb_parameter_points(const gb_sim *sim, const double *change, const gb_tangent_room *room);

/* The run goes on with parameters so far along the change. */
void gb_parameters_moved(gb_sim *sim, const double *change, double distance);

/* Time terms of all points at the stages of a step, whose instants are those of `stages`. */
int gb_parameter_terms(gb_sim *sim, const gb_tangent_room *room, const gb_lanes *stages, int count);

/* The derivative of the rates at lane `lane` of those, added to out. */
void gb_rates_by_parameter(gb_sim *sim, const gb_tangent_room *room, int lane, const double *y, double *out);

/* That of all event functions that are pending, less the limits that they leave through, added to out. */
int gb_surfaces_by_parameter(gb_sim *sim, const gb_tangent_room *room, double t, const double *y, double *out);

/* That of the instant, now, at which time switch i leaves its mode. NAN: it is none. */
double gb_instant_by_parameter(const gb_sim *sim, const gb_tangent_room *room, int i);

#endif
