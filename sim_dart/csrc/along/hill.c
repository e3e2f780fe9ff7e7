#include "names.h"

#include "../hill.c"
