#include "names.h"

#include "../tree.c"

#include "end.h"
