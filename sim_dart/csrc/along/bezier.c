#include "names.h"

#include "../bezier.c"
