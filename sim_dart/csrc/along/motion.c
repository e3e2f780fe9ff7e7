#include "names.h"

#include "../motion.c"
