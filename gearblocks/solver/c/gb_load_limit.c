#include "gb_load_limit.h"
#include "gb_raise.h"

/* Most combinations of sides that are looked at. */
enum { GB_COMBINATIONS = 729 };
/* Forces scaled to a diagonal of 1: pivots below are rounding (as in the search for what is redundant). */
static const double GB_NO_PIVOT = 1e-9;
/* A pivot is taken before another one where it is larger by more than rounding. */
static const double GB_CLEARLY = 1.0 + 1e-9;

/* Forces that the motion does not tell, scaled by the roots of their diagonal, as lines over the columns of a linear
 * program; the last column is the factor of the load. */
typedef struct gb_lines {
    int count, columns;
    const int *at, *place;        /* constraint by line; line by constraint, -1 for none */
    const int *class_of, *row_of; /* by line: 0 without bounds on both sides; the equation that tells it, or -1 */
    const double *scale, *E;      /* by line; the equations, solved */
    double *line, *least, *most;  /* count x columns; bounds of the columns */
} gb_lines;

/* Not bounded on both sides, and no loss. */
static int is_unbounded(const gb_force_bounds *bounds, int i) {
    return !gb_split_is_loss(bounds, i) && !(bounds->lower[i] > -HUGE_VAL && bounds->upper[i] < HUGE_VAL);
}

/* W and the load, scaled: m x (m + 1) numbers; returns the load, the largest slip acceleration. */
static double equations(const gb_lcp *problem, const double *force, const gb_lines *lines, double *E) {
    const int n = problem->A.n, m = lines->count;
    int column[n + 1];
    double value[n + 1], load = 0.0;
    memset(E, 0, sizeof(double) * (size_t)(m * (m + 1)));
    for (int k = 0; k < m; k++) {
        double *row = E + k * (m + 1);
        for (int c = gb_delassus_row(&problem->A, lines->at[k], column, value) - 1; c >= 0; c--) {
            const int j = lines->place[column[c]];
            if (j >= 0) {
                row[j] = value[c] / (lines->scale[k] * lines->scale[j]);
                row[m] += value[c] * force[column[c]];
            }
        }
        load = fmax(load, fabs(row[m]));
        row[m] /= lines->scale[k];
    }
    return load;
}

/* Solves the equations for as many forces as they tell, those of class 0 first; row_of[]: the row that tells a force,
 * -1 where none does. */
static void eliminate(int m, double *E, const int *class_of, int *row_of) {
    int used[m + 1];
    memset(used, 0, sizeof used);
    for (int j = 0; j < m; j++) {
        row_of[j] = -1;
    }
    for (int round = 0, of_class = 0; round < m && of_class < 2;) {
        int r = 0, c = 0;
        double largest = GB_NO_PIVOT;
        for (int i = 0; i < m; i++) {
            for (int j = 0; j < m && !used[i]; j++) {
                if (row_of[j] < 0 && class_of[j] == of_class && fabs(E[i * (m + 1) + j]) > GB_CLEARLY * largest) {
                    largest = fabs(E[i * (m + 1) + j]);
                    r = i;
                    c = j;
                }
            }
        }
        if (largest == GB_NO_PIVOT) {
            of_class++;
            continue;
        }
        for (int i = 0; i < m; i++) {
            const double factor = E[i * (m + 1) + c] / E[r * (m + 1) + c];
            for (int j = 0; j <= m && i != r && factor != 0.0; j++) {
                E[i * (m + 1) + j] -= factor * E[r * (m + 1) + j];
            }
        }
        const double pivot = E[r * (m + 1) + c];
        for (int j = 0; j <= m; j++) {
            E[r * (m + 1) + j] /= pivot;
        }
        used[r] = 1;
        row_of[c] = r;
        round++;
    }
}

/* Lines over the forces that no equation tells. */
static void draw_lines(const gb_force_bounds *bounds, double most, gb_lines *lines) {
    const int m = lines->count;
    int column[m + 1], columns = 0;
    for (int j = 0; j < m; j++) {
        const int i = lines->at[j], loss = gb_split_is_loss(bounds, i);
        column[j] = columns;
        if (lines->row_of[j] < 0) {
            lines->least[columns] = loss ? -HUGE_VAL : bounds->lower[i] * lines->scale[j];
            lines->most[columns++] = loss ? HUGE_VAL : bounds->upper[i] * lines->scale[j];
        }
    }
    lines->least[columns] = 0.0;
    lines->most[columns] = most;
    lines->columns = columns + 1;
    memset(lines->line, 0, sizeof(double) * (size_t)(m * (columns + 1)));
    for (int k = 0; k < m; k++) {
        double *line = lines->line + k * (columns + 1);
        const double *row = lines->E + lines->row_of[k] * (m + 1);
        if (lines->row_of[k] < 0) {
            line[column[k]] = 1.0;
            continue;
        }
        line[columns] = row[m];
        for (int j = 0; j < m; j++) {
            line[column[j]] -= lines->row_of[j] < 0 ? row[j] : 0.0;
        }
    }
}

/* Forces of ties can circulate: two gears side by side press on each other as hard as they like, and their losses would
 * hold any load. As hard as the load, and no harder. */
static void add_circulations(gb_raise *lp, const gb_lines *lines, double load) {
    const int m = lines->count;
    for (int f = 0; f < m; f++) {
        if (lines->row_of[f] >= 0 || lines->class_of[f] != 0) {
            continue;
        }
        double *row = lp->entry + lp->rows * lp->columns, norm = 1.0;
        memcpy(row, lines->line + f * lp->columns, sizeof(double) * (size_t)lp->columns);
        for (int b = 0; b < m; b++) {
            const double part =
                lines->row_of[b] >= 0 && lines->class_of[b] == 0 ? -lines->E[lines->row_of[b] * (m + 1) + f] : 0.0;
            norm += part * part;
            for (int k = 0; k < lp->columns && part != 0.0; k++) {
                row[k] += part * lines->line[b * lp->columns + k];
            }
        }
        lp->most[lp->columns + lp->rows] = sqrt(norm) * load;
        lp->least[lp->columns + lp->rows++] = -sqrt(norm) * load;
    }
}

/* The row  x_i + factor x_t + of_load r  within bounds, scaled like x_i; t < 0: without the second. */
static void add_row(gb_raise *lp, const gb_lines *lines, int i, int t, double factor, double of_load, double least,
                    double most) {
    const int a = lines->place[i], b = t < 0 ? -1 : lines->place[t];
    double *row = lp->entry + lp->rows * lp->columns;
    for (int k = 0; k < lp->columns; k++) {
        row[k] = lines->line[a * lp->columns + k] +
                 (b < 0 ? 0.0 : factor * lines->line[b * lp->columns + k] * lines->scale[a] / lines->scale[b]);
    }
    row[lp->columns - 1] += of_load * lines->scale[a];
    lp->least[lp->columns + lp->rows] = least * lines->scale[a];
    lp->most[lp->columns + lp->rows++] = most * lines->scale[a];
}

/* The loss i within what its side forward (up = 0) or backward gives for the force of its tie. */
static void add_loss(gb_raise *lp, const gb_lines *lines, const gb_force_bounds *bounds, int i, int side, int up,
                     double load) {
    const gb_loss_line line = gb_loss_on_side(bounds->losses + 5 * (long)i, side);
    const double keep = bounds->shrink ? 1.0 - bounds->shrink[i] : 1.0, scale = lines->scale[lines->place[i]];
    const double narrower = keep * fabs(line.slope) * load / (scale * scale), fixed = keep * line.fixed + narrower;
    add_row(lp, lines, i, bounds->tie_of[i], keep * line.slope, up ? narrower : -narrower, up ? -HUGE_VAL : -fixed,
            up ? fixed : HUGE_VAL);
}

/* Rows of the loss i for the force of its tie above 0, below 0, and within the rest: three sets, each convex and with 0
 * in it, that are together all that it can hold. In the first two no more is lost than all that leaves it: so it is
 * between the rests, and less than what is held within the first. */
static void add_option(gb_raise *lp, const gb_lines *lines, const gb_force_bounds *bounds, int i, int option,
                       double load) {
    const double rest = bounds->losses[5 * (long)i + 1];
    const int tie = bounds->tie_of[i];
    add_row(lp, lines, tie, -1, 0.0, 0.0,
            option == 0   ? 0.0
            : option == 1 ? -HUGE_VAL
                          : -rest,
            option == 0   ? HUGE_VAL
            : option == 1 ? 0.0
                          : rest);
    add_loss(lp, lines, bounds, i, option == 1 ? -1 : 1, 0, load);
    add_loss(lp, lines, bounds, i, option == 0 ? -1 : 1, 1, load);
    if (option < 2) {
        add_loss(lp, lines, bounds, i, 0, option == 0, load);
    }
}

/* The linear program of a combination of options, and its factor; into x the forces that it ends with, over it. */
static double raised(const gb_lines *lines, const gb_force_bounds *bounds, const double *force, const int *option,
                     double load, double *x) {
    const int m = lines->count, columns = lines->columns, most_rows = 5 * m;
    double scaled = 0.0;
    int id[columns + most_rows];
    double entry[columns * most_rows + 1], value[columns + most_rows], least[columns + most_rows],
        most[columns + most_rows];
    gb_raise lp = {0, columns, id, entry, value, least, most};
    memcpy(least, lines->least, sizeof(double) * (size_t)columns);
    memcpy(most, lines->most, sizeof(double) * (size_t)columns);
    for (int k = 0; k < m; k++) {
        const int i = lines->at[k];
        const double *losses = bounds->losses + 5 * (long)i;
        scaled = fmax(scaled, load / lines->scale[k]);
        if (!gb_split_is_loss(bounds, i)) {
            if (bounds->lower[i] > -HUGE_VAL || bounds->upper[i] < HUGE_VAL) {
                add_row(&lp, lines, i, -1, 0.0, 0.0, bounds->lower[i], bounds->upper[i]);
            }
        } else if (lines->place[bounds->tie_of[i]] >= 0) {
            add_option(&lp, lines, bounds, i, option[k], load);
        } else { /* the motion tells the force of its tie */
            const double keep = bounds->shrink ? 1.0 - bounds->shrink[i] : 1.0, tie = force[bounds->tie_of[i]];
            add_row(&lp, lines, i, -1, 0.0, 0.0, -keep * gb_loss_of(losses, tie), keep * gb_loss_of(losses, -tie));
        }
    }
    if (bounds->tie_of) {
        add_circulations(&lp, lines, scaled);
    }
    const double factor = gb_raise_last(&lp);
    for (int k = 0; k < m; k++) {
        double sum = 0.0;
        for (int q = 0; q < columns + lp.rows; q++) {
            sum += id[q] < columns ? lines->line[k * columns + id[q]] * value[q] : 0.0;
        }
        x[lines->at[k]] = sum / (lines->scale[k] * factor);
    }
    return factor;
}

/* The next combination of options; 0 after the last. */
static int next_option(const gb_lines *lines, const gb_force_bounds *bounds, int *option) {
    for (int k = 0; k < lines->count; k++) {
        const int i = lines->at[k];
        if (gb_split_is_loss(bounds, i) && lines->place[bounds->tie_of[i]] >= 0) {
            option[k] = (option[k] + 1) % (bounds->losses[5 * (long)i + 1] > 0.0 ? 3 : 2);
            if (option[k] != 0) {
                return 1;
            }
        }
    }
    return 0;
}

double gb_load_limit(const gb_lcp *problem, const int *is_own, const gb_force_bounds *bounds, const double *force,
                     double most, double *x) {
    const int n = problem->A.n;
    int at[n + 1], place[n + 1], class_of[n + 1], row_of[n + 1], option[n + 1], m = 0;
    double scale[n + 1], least[n + 1], upper[n + 1], split[n + 1], largest = 0.0;
    for (int i = 0; i < n; i++) {
        place[i] = problem->in[i] && !is_own[i] ? m : -1;
        if (place[i] >= 0) {
            const double own = gb_delassus_diagonal(&problem->A, i);
            scale[m] = own > 0.0 ? sqrt(own) : 1.0;
            class_of[m] = !is_unbounded(bounds, i);
            at[m++] = i;
        }
    }
    double E[m * (m + 1) + 1], line[m * (m + 1) + 1];
    gb_lines lines = {m, 0, at, place, class_of, row_of, scale, E, line, least, upper};
    const double load = equations(problem, force, &lines, E);
    eliminate(m, E, class_of, row_of);
    draw_lines(bounds, most, &lines);
    memset(option, 0, sizeof option);
    for (int count = 0, more = 1; more && largest < most && count < GB_COMBINATIONS; count++) {
        const double factor = raised(&lines, bounds, force, option, load, split);
        for (int k = 0; k < m && factor > largest; k++) {
            x[at[k]] = split[at[k]];
        }
        largest = fmax(factor, largest);
        more = next_option(&lines, bounds, option);
    }
    return largest;
}
