#include "names.h"

#include "../runge_kutta.c"
