#include "names.h"

#include "../law_motor.c"

#include "end.h"
