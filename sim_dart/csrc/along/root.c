#include "names.h"

#include "../root.c"

#include "end.h"
