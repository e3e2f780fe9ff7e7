#include "names.h"

#include "../pushes.c"

#include "end.h"
