#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../law_cables.c"

#include "end.h"
#endif
