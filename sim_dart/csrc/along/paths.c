#include "names.h"

#include "../paths.c"
