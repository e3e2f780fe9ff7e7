#include "names.h"

#include "../books.c"

#include "end.h"
