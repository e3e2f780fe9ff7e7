#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../step.c"

#include "end.h"
#endif
