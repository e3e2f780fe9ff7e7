/* Characters of UTF-8. */
#ifndef UTF8_H
#define UTF8_H

#include <stddef.h>

/* Length in bytes of the character that the text begins with; 0 when that is none. */
size_t utf8_length(const char *text);

/* Length in bytes of the character, or stray byte, that the text begins with. */
size_t utf8_next(const char *text);

#endif
