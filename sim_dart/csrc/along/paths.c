#include "names.h"

#include "../paths.c"

#include "end.h"
