#include "names.h"

#include "../law_ligament.c"

#include "end.h"
