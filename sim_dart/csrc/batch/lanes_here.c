#include "../blob/state.h"
#include "lane_support.h"
#include "lanes.h"

const batch_lanes *batch_lanes_for(const core *c)
{
#if HAS_WIDE_VERSIONS
    if (c->vector_size >= 8) return &BATCH_LANES_WIDEST;
    if (c->vector_size >= 4) return &BATCH_LANES_WIDE;
#endif
    (void)c;
#if HAS_LANES
    return &BATCH_LANES;
#else
    return NULL;
#endif
}
