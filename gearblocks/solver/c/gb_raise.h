/* Linear programming in few unknowns: the simplex method over quantities with bounds (Dantzig 1963, chapter 18).
 * Quantities in rows are linear in those of the columns; all lie within their bounds, which may be infinite. One of the
 * columns is raised as far as that lets it. Knows nothing of what the quantities are. */
#ifndef GB_RAISE_H
#define GB_RAISE_H

/* entry: rows x columns. id, value, least, most: of the columns, then of the rows; where a row and a column change
 * places they do so too, and id tells which is which. */
typedef struct gb_raise {
    int rows, columns, *id;
    double *entry, *value, *least, *most;
} gb_raise;

/* Raises the quantity of the last column; all are 0 before. Returns its value. */
double gb_raise_last(gb_raise *lp);

#endif
