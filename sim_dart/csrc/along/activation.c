#include "names.h"

#include "../activation.c"
