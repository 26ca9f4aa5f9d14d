#include "gb_account.h"
#include "gb_error_control.h"
#include "gb_reach.h"

void gb_keep_account(gb_sim *sim, gb_account *account) {
    sim->account = account;
}

void gb_account_size(gb_sim *sim, double h) {
    gb_account *account = sim->account;
    const struct gb_pace *control = &sim->head->control;
    const gb_options *options = &sim->head->options;
    if (!account) {
        return;
    }
    const double most = gb_min(control->h_next, options->max_step), reach = gb_reach_step(sim, most);
    account->size = GB_BY_STATE;
    if (options->step > 0.0 || options->max_step < control->h_next) {
        account->size = GB_BY_MOST;
    }
    if (reach < most) {
        account->size = GB_BY_REACH;
    }
    if (control->h_feature > 0.0 && control->h_feature < reach) {
        account->size = GB_BY_FEATURE;
    }
    if (h < reach && (account->size != GB_BY_FEATURE || h < control->h_feature)) {
        account->size = GB_BY_TURN;
    }
}

static void count(gb_sim *sim, long long *causes, long long *states, int cause) {
    causes[cause]++;
    if (cause == GB_BY_STATE || cause == GB_BY_REACH) {
        states[gb_worst_state(sim)]++;
    }
}

void gb_account_refused(gb_sim *sim, int cause) {
    gb_account *account = sim->account;
    sim->head->counts.rejected++;
    if (account) {
        count(sim, account->rejected, account->rejected_by, cause == GB_BY_STATE ? account->cause : cause);
    }
}

void gb_account_accepted(gb_sim *sim, double end, double limit) {
    gb_account *account = sim->account;
    if (account) {
        const int at_event = sim->head->front.t1 < end, at_limit = end >= limit;
        const int cause = account->size != GB_BY_STATE ? account->size : account->cause;
        count(sim, account->accepted, account->accepted_by, at_event ? GB_BY_EVENT : at_limit ? GB_BY_TIME : cause);
    }
}
