#include "names.h"

#include "../bezier.c"

#include "end.h"
