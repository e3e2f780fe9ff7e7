/* Reading of whole files with paths in UTF-8. */
#ifndef READ_FILE_H
#define READ_FILE_H

#include <stddef.h>

/* Return the bytes of a file in `folder`, and a further zero, on the heap; NULL if it cannot be read. */
unsigned char *read_file(const char *folder, const char *name, size_t *size);

#endif
