#include "names.h"

#include "../limits.c"

#include "end.h"
