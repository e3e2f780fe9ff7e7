#include "names.h"

#include "../limits.c"
