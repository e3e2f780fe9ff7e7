#include "names.h"

#include "../sequence.c"

#include "end.h"
