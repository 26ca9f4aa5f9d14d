#include "gb_snapshot.h"
#include "gb_inputs.h"
#include "gb_memory.h"
#include "gb_report.h"
#include "gb_rosenbrock.h"

size_t gb_snapshot_size(const gb_sim *sim) {
    return sim->block_bytes;
}

void gb_save(const gb_sim *sim, void *block) {
    memcpy(block, sim->head, sim->block_bytes);
}

int gb_restore(gb_sim *sim, const void *block) {
    gb_head other;
    memcpy(&other, block, sizeof other);
    if (other.key != sim->head->key || other.bytes != sim->head->bytes) {
        return gb_fail(sim, GB_ERR_STATE, 0, sim->head->front.t1, (double)other.bytes);
    }
    memcpy(sim->head, block, sim->block_bytes);
    gb_set_method(sim, sim->head->method);
    sim->log.count = sim->log.flushed = 0;
    gb_kinematic_links(sim);
    gb_input_broadcast(sim);
    return GB_DONE;
}
