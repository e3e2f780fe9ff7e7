#include "file.h"

#include "../platform/crc32.h"
#include "../platform/read_file.h"

#include <stdlib.h>
#include <string.h>

enum { FORMAT_VERSION = 2, HEADER_SIZE = 32 };

static const char MAGIC[8] = {'C', 'A', 'R', 'D', 'S', 'N', 'A', 'T'};

static uint32_t u32_at(const unsigned char *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

int native_file_exists(const char *folder)
{
    size_t size;
    unsigned char *bytes = read_file(folder, "native.bin", &size);
    free(bytes);
    return bytes != NULL;
}

/* Return the error in the file, or NULL. */
static const char *parse(struct native_file *file, size_t size)
{
    static const char damaged[] = "damaged";
    const unsigned char *bytes = file->bytes;
    if (size < HEADER_SIZE || memcmp(bytes, MAGIC, sizeof MAGIC) || u32_at(bytes + 12) != size ||
        u32_at(bytes + 16) != crc32_of(bytes + 20, size - 20) || u32_at(bytes + 20) >= NATIVE_KINDS)
        return damaged;
    file->kind = (enum native_kind)u32_at(bytes + 20);
    if (u32_at(bytes + 8) != FORMAT_VERSION || u32_at(bytes + 28) != native_layout_hash(file->kind))
        return "of another version than this library";
    const size_t blob = u32_at(bytes + 24), padded = (blob + 7u) & ~(size_t)7u, body = size - HEADER_SIZE;
    if (blob > body || padded > body)
        return damaged;
    file->blob = bytes + HEADER_SIZE;
    file->blob_size = blob;
    file->settings = bytes + HEADER_SIZE + padded;
    file->settings_size = body - padded;
    return NULL;
}

int native_file_read(struct native_file *file, const char *folder, struct text *error)
{
    size_t size = 0;
    memset(file, 0, sizeof *file);
    file->bytes = read_file(folder, "native.bin", &size);
    const char *wrong = file->bytes ? parse(file, size) : "missing";
    if (wrong) {
        text_set(error, "%s/native.bin is %s; unpack or build the FMU again", folder, wrong);
        native_file_free(file);
        return 1;
    }
    return 0;
}

int native_file_copy(struct native_file *file, const void *bytes, size_t size, struct text *error)
{
    memset(file, 0, sizeof *file);
    file->bytes = malloc(size + 1);
    if (file->bytes)
        memcpy(file->bytes, bytes, size);
    const char *wrong = file->bytes ? parse(file, size) : "too large for the memory";
    if (wrong) {
        text_set(error, "the model's file is %s", wrong);
        native_file_free(file);
    }
    return wrong != NULL;
}

void native_file_free(struct native_file *file)
{
    free(file->bytes);
    file->bytes = NULL;
}
