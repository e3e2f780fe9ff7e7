#include "names.h"

#include "../sequence.c"
