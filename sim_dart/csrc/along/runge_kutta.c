#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../runge_kutta.c"

#include "end.h"
#endif
