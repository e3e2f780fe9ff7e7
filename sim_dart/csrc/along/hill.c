#include "names.h"

#include "../hill.c"

#include "end.h"
