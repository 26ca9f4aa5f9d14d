/* What a lossy gear loses: friction in proportion to the force of its tie, on two sides (it drives, or is driven).
 *     d = sign(slip), u = d lambda, m = u + rest:   lost = share m + rest,   (share, rest) by the sign of m.
 * What enters is u + lost = (1 + share) m: continuous and, where no efficiency is negative, growing with u.
 * Source: Pelchen, Schweiger, Otter 2002, with the force that leaves the gear as lambda, so that a self-locking gear
 * has one answer for each. Knows nothing of other constraints. */
#ifndef GB_LOSS_H
#define GB_LOSS_H

#include "gb_lcp.h"

/* The force that a lossy gear loses while it slides, along its direction: with u, the force of its tie along that
 * direction, m = u + rest and  lost = share m + rest. losses: share and rest of a gear that drives (m >= 0), then of
 * one that is driven (m < 0). Where the rests leave a gap, -rest driven <= u <= -rest driving, nothing enters: lost =
 * -u. Side of a gear: 1 it drives, -1 it is driven, 0 nothing enters. As a line over u: lost = slope u + fixed. */
typedef struct gb_loss_line {
    double slope, fixed;
} gb_loss_line;

/* Losses read from a table are none below zero by more than rounding, and at rest, where nothing else acts, by none: a
 * gear that gains 1e-17 N m there has no motion. */
static inline void gb_loss_without_gain(double *losses) {
    losses[0] = fmax(losses[0], 0.0);
    losses[1] = fmax(losses[1], 0.0);
    losses[2] = fmin(losses[2], 0.0);
    losses[3] = fmax(losses[3], 0.0);
}

static inline int gb_loss_side(const double *losses, double u) {
    return u + losses[1] >= 0.0 ? 1 : u + losses[3] < 0.0 ? -1 : 0;
}

static inline gb_loss_line gb_loss_on_side(const double *losses, int side) {
    const double *of = losses + (side < 0 ? 2 : 0);
    const gb_loss_line line = {side ? of[0] : -1.0, side ? (1.0 + of[0]) * of[1] : 0.0};
    return line;
}

static inline double gb_loss_of(const double *losses, double u) {
    const gb_loss_line line = gb_loss_on_side(losses, gb_loss_side(losses, u));
    return line.slope * u + line.fixed;
}

/* >= 0: the force u along the direction of sliding is one of this side. */
static inline double gb_loss_margin(const double *losses, int side, double u) {
    return side > 0 ? u + losses[1] : side < 0 ? -(u + losses[3]) : fmin(u + losses[3], -(u + losses[1]));
}

/* Event function of the sign of the force inside a lossy gear that slides in a direction: >= 0 while the sign is 1 or
 * 0, <= 0 while it is -1. At rest the force itself. */
static inline double gb_loss_sign(const double *losses, double direction, double sign, double tie) {
    const int side = (int)(direction * sign);
    if (direction == 0.0 || side == 0) {
        return direction == 0.0 ? tie : gb_loss_margin(losses, 0, direction * tie);
    }
    return tie + direction * losses[side > 0 ? 1 : 3];
}

/* By how much the force that a lossy gear needs to stay at rest leaves the range between its losses in either
 * direction,
 * [-lost(tie), lost(-tie)]; what is rounding of the forces counts as inside. */
static inline double gb_loss_excess(const double *losses, double tie, double force) {
    const double excess = fmax(-gb_loss_of(losses, tie) - force, force - gb_loss_of(losses, -tie));
    return excess - 1e-13 * (fabs(tie) + fabs(force));
}

/* A gear at rest for which sides forward and backward were assumed, and that may lose `keep` of what it does: the range
 * is that of its tie but for rounding, or its force lies inside both by more than that. */
static inline int gb_loss_agrees(const double *losses, const int *sides, double tie, double force, double keep,
                                 double rounding) {
    const gb_loss_line up = gb_loss_on_side(losses, sides[0]), down = gb_loss_on_side(losses, sides[1]);
    const double least = -(up.slope * tie + up.fixed), most = down.fixed - down.slope * tie;
    const double true_least = -gb_loss_of(losses, tie), true_most = gb_loss_of(losses, -tie);
    if (fabs(least - true_least) <= rounding && fabs(most - true_most) <= rounding) {
        return 1;
    }
    return force > keep * fmax(least, true_least) + rounding && force < keep * fmin(most, true_most) - rounding;
}

/* Sides forward and backward of a gear at rest, by the force that leaves it: above all rests, below, between; between
 * the rests where nothing enters. So many of these options there are. */
enum { GB_LOSS_OPTIONS = 5 };

static inline void gb_loss_option(int option, int *sides) {
    static const int all[GB_LOSS_OPTIONS][2] = {{1, -1}, {-1, 1}, {1, 1}, {1, 0}, {0, 1}};
    sides[0] = all[option][0];
    sides[1] = all[option][1];
}

static inline int gb_loss_options(const double *losses) {
    return losses[1] < losses[3] ? 5 : losses[1] > 0.0 ? 3 : 2;
}

/* The forces of the tie for which a gear at rest has these sides; from a range that is wider. */
static inline void gb_loss_range(const double *losses, int forward, int backward, double *least, double *most) {
    const double driving = losses[1], driven = fmax(losses[1], losses[3]);
    *least = forward == 1   ? (backward == 1   ? -driving
                               : backward == 0 ? driving
                                               : driven)
             : forward == 0 ? -driven
                            : *least;
    *most = backward == 1   ? (forward == 1   ? driving
                               : forward == 0 ? -driving
                                              : -driven)
            : backward == 0 ? driven
                            : *most;
}

#endif
