#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../pulley.c"

#include "end.h"
#endif
