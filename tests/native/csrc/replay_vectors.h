/* The replay of vectors, and what it asks of the machine that it runs on. */
#ifndef REPLAY_VECTORS_H
#define REPLAY_VECTORS_H

#include <stddef.h>

/* 0 if all that came out is as near to what is expected as the vectors ask. */
int replay_vectors(const char *bytes, size_t size);

void *room(size_t size);      /* memory, 8-byte aligned, never given back */
void say(const char *text);   /* to whoever watches */
void fail(const char *what, const char *name); /* say it and end */

#endif
