#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../law_degroote.c"

#include "end.h"
#endif
