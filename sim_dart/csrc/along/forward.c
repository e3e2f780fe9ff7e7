#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../forward.c"

#include "end.h"
#endif
