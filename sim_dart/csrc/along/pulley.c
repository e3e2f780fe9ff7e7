#include "names.h"

#include "../pulley.c"
