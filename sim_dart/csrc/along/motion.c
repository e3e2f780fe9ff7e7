#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../motion.c"

#include "end.h"
#endif
