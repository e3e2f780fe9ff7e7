#include "names.h"

#include "../wrap.c"

#include "end.h"
