#include "names.h"

#include "../wrap.c"
