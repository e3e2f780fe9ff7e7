#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../law_thelen.c"

#include "end.h"
#endif
