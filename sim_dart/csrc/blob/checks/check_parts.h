#ifndef CARDSFLOW_CHECK_PARTS_H
#define CARDSFLOW_CHECK_PARTS_H

#include "../state.h"

/* Check that the program contains the parts that the robot needs, see ../../optional_parts.h. */
CORE_INSIDE int check_parts(const blob_view *b, char *message, size_t capacity);

#endif
