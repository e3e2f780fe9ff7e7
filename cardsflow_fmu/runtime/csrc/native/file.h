/* The model of a native FMU: a robot and settings, read from resources/native.bin.
 *
 * The file is little-endian:
 *
 *     8 bytes  magic "CARDSNAT"
 *     u32      version of this format, 2
 *     u32      length of the whole file
 *     u32      CRC-32 of all following bytes
 *     u32      kind of model: 0 plant, 1 controller, 2 reference, 3 sensors, 4 estimator
 *     u32      length of the robot blob; 0 for a reference, which has no robot
 *     u32      hash of the layout of the settings
 *     the robot blob, padded to 8 bytes; the settings, see layout.h */
#ifndef NATIVE_FILE_H
#define NATIVE_FILE_H

#include "../platform/text.h"
#include "layout.h"

#include <stddef.h>

struct native_file {
    enum native_kind kind;
    const void *blob, *settings;
    size_t blob_size, settings_size;
    unsigned char *bytes; /* contains all of it */
};

/* Return whether an FMU has this file. */
int native_file_exists(const char *folder);

/* Read the file. Return 0, or nonzero with a message. */
int native_file_read(struct native_file *file, const char *folder, struct text *error);
/* Read a copy of the bytes of the file. */
int native_file_copy(struct native_file *file, const void *bytes, size_t size, struct text *error);
void native_file_free(struct native_file *file);

#endif
