#include "names.h"

#include "../law_mckibben.c"

#include "end.h"
