#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../pushes.c"

#include "end.h"
#endif
