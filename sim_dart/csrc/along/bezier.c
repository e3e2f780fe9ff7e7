#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../bezier.c"

#include "end.h"
#endif
