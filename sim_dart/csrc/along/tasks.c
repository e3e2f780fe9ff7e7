#include "names.h"

#include "../tasks.c"
