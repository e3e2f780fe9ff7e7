#include "names.h"

#include "../pulley.c"

#include "end.h"
