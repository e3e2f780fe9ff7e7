#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../law_mckibben.c"

#include "end.h"
#endif
