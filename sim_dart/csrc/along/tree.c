#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../tree.c"

#include "end.h"
#endif
