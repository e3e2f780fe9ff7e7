#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../sequence.c"

#include "end.h"
#endif
