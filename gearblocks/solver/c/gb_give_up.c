#include "gb_give_up.h"
#include "gb_error_control.h"
#include "gb_growth.h"
#include "gb_jump.h"
#include "gb_modes.h"
#include "gb_report.h"

/* The index of what is not finite in the step just tried. */
static int name_taint(gb_sim *sim) {
    const int total = sim->model->n_total;
    for (int j = 0; j <= sim->method->stages; j++) {
        const int full = sim->method->full[j] ? total : sim->model->n_padded;
        if (gb_check_finite(sim, GB_ERR_NAN_RATE, sim->k + (size_t)j * (size_t)total, full, 0, sim->lanes.t[j]) !=
            GB_DONE) {
            return sim->head->report.code;
        }
    }
    return gb_check_finite(sim, GB_ERR_NAN_RATE, sim->z, total, 0, sim->lanes.t[sim->method->stages]);
}

int gb_give_up(gb_sim *sim, int code, int finite, double h) {
    if (code != GB_DONE) {
        return code;
    }
    if (finite && gb_passes_corner(sim)) {
        return GB_DONE;
    }
    const int chatters = finite ? gb_flipped_just_now(sim) : -1;
    if (chatters >= 0) {
        return gb_fail(sim, GB_ERR_CHATTER, chatters, sim->head->front.t1, sim->events.flips[chatters]);
    }
    return gb_name_escape(sim, finite ? gb_fail(sim, GB_ERR_STEP, gb_worst_state(sim), sim->head->front.t1, h)
                                      : name_taint(sim));
}
