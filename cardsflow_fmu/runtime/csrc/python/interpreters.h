/* Python interpreters that may have the package. */
#ifndef INTERPRETERS_H
#define INTERPRETERS_H

#include <stddef.h>

struct interpreter {
    const char *source; /* source of the path, for messages */
    char *program;      /* path or name, on the heap */
};

enum { MAX_INTERPRETERS = 3 };

/* Find the candidates, in order: only CARDSFLOW_PYTHON, if it is set; otherwise the path in
 * resources/python.txt, the one of VIRTUAL_ENV, and python3. Return their number. */
size_t interpreters_find(const char *resources, struct interpreter list[MAX_INTERPRETERS]);

void interpreters_free(struct interpreter list[], size_t count);

#endif
