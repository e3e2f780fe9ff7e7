#include "names.h"

#include "../forward.c"
