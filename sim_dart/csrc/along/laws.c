#include "names.h"

#include "../laws.c"
