#include "names.h"

#include "../law_spring.c"

#include "end.h"
