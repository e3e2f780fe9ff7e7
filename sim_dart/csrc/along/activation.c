#include "names.h"

#include "../activation.c"

#include "end.h"
