/* Reports: why a run cannot go on, events, counters.
 * Knows nothing of what they mean. */
#ifndef GB_REPORT_H
#define GB_REPORT_H

#include "gb_internal.h"

/* Keeps the report and answers `code`. */
int gb_fail(gb_sim *sim, int code, int index, double t, double value);

/* Fails with `code` and shift + the index of the first entry that is NaN or infinite. */
int gb_check_finite(gb_sim *sim, int code, const double *x, int count, int shift, double t);

/* Notes an event at the front; kind as in gb_event, 2: an impact. */
void gb_log(gb_sim *sim, int index, int kind, double before, double after);

#endif
