#include "names.h"

#include "../law_millard.c"

#include "end.h"
