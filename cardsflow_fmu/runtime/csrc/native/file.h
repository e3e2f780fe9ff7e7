/* The model of a native FMU: a robot and settings, read from resources/native.bin.
 *
 * The file is little-endian:
 *
 *     8 bytes  magic "CARDSNAT"
 *     u32      version of this format, 2
 *     u32      length of the whole file
 *     u32      CRC-32 of all that follows
 *     u32      kind of model: 0 plant, 1 controller, 2 reference, 3 sensors, 4 estimator
 *     u32      length of the robot's blob; 0 for a reference, which has none
 *     u32      hash of the settings' layout
 *     the robot's blob, padded to 8 bytes; the settings, see layout.h
 */
#ifndef NATIVE_FILE_H
#define NATIVE_FILE_H

#include "../platform/text.h"
#include "layout.h"

#include <stddef.h>

struct native_file {
    enum native_kind kind;
    const void *blob, *settings;
    size_t blob_size, settings_size;
    unsigned char *bytes; /* holds all of it */
};

/* Whether an FMU has such a file. */
int native_file_exists(const char *folder);

/* 0, or nonzero with a message. */
int native_file_read(struct native_file *file, const char *folder, struct text *error);
/* The same of a copy of the file's bytes. */
int native_file_copy(struct native_file *file, const void *bytes, size_t size, struct text *error);
void native_file_free(struct native_file *file);

#endif
