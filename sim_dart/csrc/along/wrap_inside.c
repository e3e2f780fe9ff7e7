#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../wrap_inside.c"

#include "end.h"
#endif
