#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../limits.c"

#include "end.h"
#endif
