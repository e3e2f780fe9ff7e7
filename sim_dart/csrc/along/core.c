#include "names.h"

#include "../core.c"
