/* Damage to files: the number of a mutation determines it. */
#ifndef MUTATE_H
#define MUTATE_H

#include <stddef.h>
#include <stdint.h>

/* Return the contents of a file on the heap. End the program if the file cannot be read. */
unsigned char *file_contents(const char *path, size_t *size);

/* Steele, Lea and Flood's splitmix64. */
uint64_t draw(uint64_t *state);

/* Return a copy of the contents with one to four damaged places after the first `safe` bytes. The size may
   change. The block has exactly this size, so that the sanitizer detects reads beyond it. */
unsigned char *mutated(uint64_t *state, const unsigned char *contents, size_t *size, size_t safe);

#endif
