#include "../blob/state.h"
#include "lane_support.h"
#include "lanes.h"

#if HAS_LANES
extern const batch_lanes BATCH_LANES;
#endif
#if HAS_WIDE_VERSION
extern const batch_lanes BATCH_LANES_WIDE;
#endif

const batch_lanes *batch_lanes_for(const core *c)
{
#if HAS_WIDE_VERSION
    if (c->has_wide_lanes) return &BATCH_LANES_WIDE;
#endif
    (void)c;
#if HAS_LANES
    return &BATCH_LANES;
#else
    return NULL;
#endif
}
