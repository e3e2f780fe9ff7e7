#include "names.h"

#include "../laws.c"

#include "end.h"
