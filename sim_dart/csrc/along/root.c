#include "names.h"

#include "../root.c"
