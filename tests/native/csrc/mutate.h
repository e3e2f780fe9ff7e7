/* Damage to files: a mutation's number alone decides it. */
#ifndef MUTATE_H
#define MUTATE_H

#include <stddef.h>
#include <stdint.h>

/* The contents of a file on the heap. Ends the program if it cannot be read. */
unsigned char *file_contents(const char *path, size_t *size);

/* Steele, Lea and Flood's splitmix64. */
uint64_t draw(uint64_t *state);

/* A copy of the contents with one to four pieces of damage behind the first `safe` bytes, in a block of
   exactly its size, so that the sanitizer sees what reads beyond; its size may change.                  */
unsigned char *mutated(uint64_t *state, const unsigned char *contents, size_t *size, size_t safe);

#endif
