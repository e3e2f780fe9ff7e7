#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../tasks.c"

#include "end.h"
#endif
