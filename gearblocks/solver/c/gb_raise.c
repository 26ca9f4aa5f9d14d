#include "gb_raise.h"
#include <math.h>

/* Entries below are rounding of those of size 1. */
static const double GB_NO_ENTRY = 1e-11;
/* Of the largest bound of all: within so little a quantity is at its bound. */
static const double GB_SLACK = 1e-12;

/* The place of the quantity with this id. */
static int place_of(const gb_raise *lp, int id) {
    int at = 0;
    while (lp->id[at] != id) {
        at++;
    }
    return at;
}

/* A column whose change raises the quantity at `goal`, and its direction; -1: there is none. The steepest, and of late
 * the one with the least id: with that rule no sequence of exchanges comes back to where it began (Bland 1977). */
static int entering(const gb_raise *lp, int goal, int late, int *direction) {
    int best = -1;
    double steepest = GB_NO_ENTRY;
    for (int j = 0; j < lp->columns; j++) {
        const double slope =
            goal < lp->columns ? (double)(j == goal) : lp->entry[(goal - lp->columns) * lp->columns + j];
        const int up = slope > 0.0, free = up ? lp->value[j] < lp->most[j] : lp->value[j] > lp->least[j];
        if (free && fabs(slope) > (late ? GB_NO_ENTRY : steepest) && !(late && best >= 0 && lp->id[best] < lp->id[j])) {
            best = j;
            steepest = fabs(slope);
            *direction = up ? 1 : -1;
        }
    }
    return best;
}

/* How fast row i changes with column j in a direction, and what is left of its room there; no limit: HUGE_VAL. */
static double room(const gb_raise *lp, int i, int j, int direction, double *rate) {
    const int at = lp->columns + i;
    *rate = direction * lp->entry[i * lp->columns + j];
    const double left = *rate > 0.0 ? lp->most[at] - lp->value[at] : lp->value[at] - lp->least[at];
    return fabs(*rate) > GB_NO_ENTRY ? fmax(left, 0.0) : HUGE_VAL;
}

/* How far column j goes in a direction, and the row that stops it; -1: its own bound. Of the rows that would be passed
 * by no more than `slack` the one that changes fastest: a slow one that stops it a rounding sooner would make that
 * rounding large (Harris 1973). */
static double stopping(const gb_raise *lp, int j, int direction, double slack, int *row) {
    const double own = direction > 0 ? lp->most[j] - lp->value[j] : lp->value[j] - lp->least[j];
    double farthest = own + slack, fastest = 0.0, step = own, rate;
    for (int i = 0; i < lp->rows; i++) {
        const double left = room(lp, i, j, direction, &rate);
        farthest = left < HUGE_VAL ? fmin(farthest, (left + slack) / fabs(rate)) : farthest;
    }
    *row = -1;
    for (int i = 0; i < lp->rows; i++) {
        const double left = room(lp, i, j, direction, &rate);
        if (left < HUGE_VAL && left / fabs(rate) <= farthest && fabs(rate) > fastest &&
            !(own <= farthest && fabs(rate) < 1.0)) {
            fastest = fabs(rate);
            step = left / fabs(rate);
            *row = i;
        }
    }
    return step;
}

/* Of the largest bound: so little beyond its bounds is within them. */
static double slack_of(const gb_raise *lp) {
    double largest = 0.0;
    for (int k = 0; k < lp->columns + lp->rows; k++) {
        const int counts = k != lp->columns - 1;
        largest = counts && lp->most[k] < HUGE_VAL ? fmax(largest, fabs(lp->most[k])) : largest;
        largest = counts && lp->least[k] > -HUGE_VAL ? fmax(largest, fabs(lp->least[k])) : largest;
    }
    return GB_SLACK * largest;
}

static void swap(double *list, int a, int b) {
    const double kept = list[a];
    list[a] = list[b];
    list[b] = kept;
}

/* Row r and column j change places. */
static void exchange(gb_raise *lp, int r, int j) {
    double *row = lp->entry + r * lp->columns;
    const double pivot = row[j];
    for (int k = 0; k < lp->columns; k++) {
        row[k] = k == j ? 1.0 / pivot : -row[k] / pivot;
    }
    for (int i = 0; i < lp->rows; i++) {
        double *other = lp->entry + i * lp->columns;
        const double factor = other[j];
        for (int k = 0; k < lp->columns && i != r && factor != 0.0; k++) {
            other[k] = (k == j ? 0.0 : other[k]) + factor * row[k];
        }
    }
    swap(lp->value, lp->columns + r, j);
    swap(lp->least, lp->columns + r, j);
    swap(lp->most, lp->columns + r, j);
    const int kept = lp->id[lp->columns + r];
    lp->id[lp->columns + r] = lp->id[j];
    lp->id[j] = kept;
}

double gb_raise_last(gb_raise *lp) {
    const int all = lp->rows + lp->columns, raised = lp->columns - 1;
    const double slack = slack_of(lp);
    for (int k = 0; k < all; k++) {
        lp->id[k] = k;
        lp->value[k] = 0.0;
    }
    for (int round = 0; round < 8 * all + 16; round++) {
        int direction = 0, row;
        const int goal = place_of(lp, raised), j = entering(lp, goal, round > 2 * all, &direction);
        const double step = j < 0 ? HUGE_VAL : stopping(lp, j, direction, slack, &row);
        if (!(step < HUGE_VAL)) {
            break;
        }
        for (int i = 0; i < lp->rows; i++) {
            lp->value[lp->columns + i] += direction * step * lp->entry[i * lp->columns + j];
        }
        lp->value[j] += direction * step;
        if (row >= 0) {
            const int at = lp->columns + row, up = direction * lp->entry[row * lp->columns + j] > 0.0;
            lp->value[at] = up ? lp->most[at] : lp->least[at];
            exchange(lp, row, j);
        } else {
            lp->value[j] = direction > 0 ? lp->most[j] : lp->least[j];
        }
    }
    return lp->value[place_of(lp, raised)];
}
