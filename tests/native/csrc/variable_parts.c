#include "variable_parts.h"

int used_parts[7];
