#include "names.h"

#include "../step.c"

#include "end.h"
