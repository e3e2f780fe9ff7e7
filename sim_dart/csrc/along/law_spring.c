#include "names.h"

#include "../law_spring.c"
