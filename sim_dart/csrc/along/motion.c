#include "names.h"

#include "../motion.c"

#include "end.h"
