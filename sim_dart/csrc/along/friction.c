#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../friction.c"

#include "end.h"
#endif
