#include "names.h"

#include "../pushes.c"
