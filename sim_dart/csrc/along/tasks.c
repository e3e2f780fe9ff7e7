#include "names.h"

#include "../tasks.c"

#include "end.h"
