/* Motion that is rounding: of bodies at rest, whose speeds are no larger than what rounding makes of the run. Its
 * energy (gb_rounding_energy in gb_core.h) is no error of the ledger. Knows nothing of how the noise of the rates is
 * measured. */
#ifndef GB_ROUNDING_MOTION_H
#define GB_ROUNDING_MOTION_H

#include "gb_internal.h"

/* No speed has been larger than the noise of its rate may have made it in the run so far, all of one sign. */
int gb_moves_by_rounding(const gb_sim *sim);

#endif
