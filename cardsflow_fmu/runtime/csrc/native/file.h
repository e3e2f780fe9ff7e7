/* The model of a native FMU: a robot and settings, read from resources/native.bin.
 *
 * The file is little-endian:
 *
 *     8 bytes  magic "CARDSNAT"
 *     u32      version of this format, 1
 *     u32      length of the whole file
 *     u32      CRC-32 of all that follows
 *     u32      kind of model: 0 plant, 1 controller, 2 reference
 *     u32      length of the robot's blob; 0 for a reference, which has none
 *     u32      number of settings
 *     the robot's blob, padded to 8 bytes; f64 each setting, in the order that the kind of model says
 */
#ifndef NATIVE_FILE_H
#define NATIVE_FILE_H

#include "../platform/text.h"

#include <stddef.h>
#include <stdint.h>

enum native_kind { NATIVE_PLANT, NATIVE_CONTROLLER, NATIVE_REFERENCE, NATIVE_KINDS };

struct native_file {
    enum native_kind kind;
    const void *blob;
    size_t blob_size;
    const double *settings;
    size_t settings_count;
    unsigned char *bytes; /* holds all of it */
};

/* Whether an FMU has such a file. */
int native_file_exists(const char *folder);

/* 0, or nonzero with a message. */
int native_file_read(struct native_file *file, const char *folder, struct text *error);
void native_file_free(struct native_file *file);

/* The next settings, taken off the file's; NULL where there are not so many left. */
const double *native_file_take(struct native_file *file, size_t count);
/* A count, and as many indices below `end`. 0, or nonzero where that is not what comes next. */
int native_file_take_indices(struct native_file *file, size_t end, size_t *count, const double **indices);

#endif
