#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../law_motor.c"

#include "end.h"
#endif
