/* Whole files from paths in UTF-8. */
#ifndef READ_FILE_H
#define READ_FILE_H

#include <stddef.h>

/* The bytes of a file on the heap; NULL when it cannot be read. */
unsigned char *read_file(const char *path, size_t *size);

#endif
