#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../laws.c"

#include "end.h"
#endif
