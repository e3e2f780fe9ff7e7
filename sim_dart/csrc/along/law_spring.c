#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../law_spring.c"

#include "end.h"
#endif
