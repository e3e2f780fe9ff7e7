#include "names.h"

#include "../law_thelen.c"

#include "end.h"
