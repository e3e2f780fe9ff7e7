/* Where a Python may be that has the package. */
#ifndef INTERPRETERS_H
#define INTERPRETERS_H

#include <stddef.h>

struct interpreter {
    const char *source; /* who names it, for messages */
    char *program;      /* path or name, on the heap */
};

enum { MAX_INTERPRETERS = 3 };

/* The ones to try, in this order: what CARDSFLOW_PYTHON names, and then no other; what
 * resources/python.txt has recorded; that of VIRTUAL_ENV; python3. Returns how many. */
size_t interpreters_find(const char *resources, struct interpreter found[MAX_INTERPRETERS]);

void interpreters_free(struct interpreter found[], size_t count);

#endif
