#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../activation.c"

#include "end.h"
#endif
