#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../paths.c"

#include "end.h"
#endif
