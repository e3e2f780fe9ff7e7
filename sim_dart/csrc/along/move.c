#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../move.c"

#include "end.h"
#endif
