#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../wrap_lanes.c"

#include "end.h"
#endif
