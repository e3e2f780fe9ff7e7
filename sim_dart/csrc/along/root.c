#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../root.c"

#include "end.h"
#endif
