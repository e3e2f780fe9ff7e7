#include "names.h"

#include "../wrap_inside.c"

#include "end.h"
