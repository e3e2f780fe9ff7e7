#include "names.h"

#include "../friction.c"

#include "end.h"
