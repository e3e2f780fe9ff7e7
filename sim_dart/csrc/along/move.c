#include "names.h"

#include "../move.c"

#include "end.h"
