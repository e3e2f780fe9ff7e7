#include "support.h"
#if HAS_ALONG
#include "names.h"

#include "../law_ligament.c"

#include "end.h"
#endif
