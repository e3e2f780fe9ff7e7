/* lanes.c for processors with AVX2. */
#include "lane_support.h"

#if HAS_WIDE_VERSION
#define LANES_WIDE
#include "lanes.c"
#endif
