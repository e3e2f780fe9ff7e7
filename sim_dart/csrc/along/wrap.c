#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../wrap.c"

#include "end.h"
#endif
