#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../hill.c"

#include "end.h"
#endif
