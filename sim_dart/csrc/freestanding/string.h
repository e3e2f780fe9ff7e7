/* The part of <string.h> that the core and the control laws use, for machines without a C library. */
#ifndef CARDSFLOW_FREESTANDING_STRING_H
#define CARDSFLOW_FREESTANDING_STRING_H

#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t size);
void *memmove(void *to, const void *from, size_t size);
void *memset(void *to, int byte, size_t size);
int strcmp(const char *a, const char *b);
int strncmp(const char *a, const char *b, size_t size);

#endif
