#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../law_millard.c"

#include "end.h"
#endif
