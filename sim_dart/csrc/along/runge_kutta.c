#include "names.h"

#include "../runge_kutta.c"

#include "end.h"
