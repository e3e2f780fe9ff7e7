#include "names.h"

#include "../law_cables.c"

#include "end.h"
