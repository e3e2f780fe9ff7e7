#include "names.h"

#include "../forward.c"

#include "end.h"
