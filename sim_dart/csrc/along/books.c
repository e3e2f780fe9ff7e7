#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../books.c"

#include "end.h"
#endif
