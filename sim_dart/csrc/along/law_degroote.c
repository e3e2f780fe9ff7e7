#include "names.h"

#include "../law_degroote.c"

#include "end.h"
