/* Characters in UTF-8. */
#ifndef UTF8_H
#define UTF8_H

#include <stddef.h>

/* Return the length in bytes of the first character of the text; 0 if it is invalid. */
size_t utf8_length(const char *text);

/* Return the length in bytes of the first character or invalid byte of the text. */
size_t utf8_next(const char *text);

#endif
