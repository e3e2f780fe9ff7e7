/* The replay of vectors, and the functions that the machine must provide. */
#ifndef REPLAY_VECTORS_H
#define REPLAY_VECTORS_H

#include <stddef.h>

/* Return 0 if all results agree with the expected ones within the tolerances of the vectors. */
int replay_vectors(const char *bytes, size_t size);

void *allocate(size_t size);      /* return memory, 8-byte aligned, never freed */
void say(const char *text);   /* print a text */
void fail(const char *what, const char *name); /* print a message and end */

#endif
