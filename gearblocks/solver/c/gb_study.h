/* Many runs of one model, one after the other, of each of which a few numbers are kept. The call is that of gb_core.h:
 * gb_study_run. Knows nothing of what points and numbers mean. */
#ifndef GB_STUDY_H
#define GB_STUDY_H

#include "gb_core.h"

#endif
