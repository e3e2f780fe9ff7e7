/* The blob with its numbers as here: the same fields in the same order, wider. */
#ifndef CARDSFLOW_ALONG_BLOB_H
#define CARDSFLOW_ALONG_BLOB_H

#include <stddef.h>

/* Bytes of it, from the header of a blob that core_open has taken. */
size_t along_blob_size(const void *blob);
void along_blob_widen(const void *blob, void *wide);

#endif
