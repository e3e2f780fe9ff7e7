#include "names.h"

#include "../step.c"
