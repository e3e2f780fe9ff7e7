#include "names.h"

#include "../law_ligament.c"
