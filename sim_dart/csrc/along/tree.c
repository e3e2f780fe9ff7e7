#include "names.h"

#include "../tree.c"
