#include "names.h"

#include "../wrap_lanes.c"

#include "end.h"
