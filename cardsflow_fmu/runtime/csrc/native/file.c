#include "file.h"

#include "../platform/read_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FORMAT_VERSION = 1, HEADER_SIZE = 32 };

static const char MAGIC[8] = {'C', 'A', 'R', 'D', 'S', 'N', 'A', 'T'};

static uint32_t u32_at(const unsigned char *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static uint32_t crc32_of(const unsigned char *bytes, size_t size)
{
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int k = 0; k < 8; k++)
            crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1u)));
    }
    return ~crc;
}

static char *path_in(const char *folder)
{
    static const char name[] = "/native.bin";
    char *path = malloc(strlen(folder) + sizeof name);
    if (path) {
        strcpy(path, folder);
        strcat(path, name);
    }
    return path;
}

static unsigned char *bytes_in(const char *folder, size_t *size)
{
    char *path = path_in(folder);
    unsigned char *bytes = path ? read_file(path, size) : NULL;
    free(path);
    return bytes;
}

int native_file_exists(const char *folder)
{
    size_t size;
    unsigned char *bytes = bytes_in(folder, &size);
    free(bytes);
    return bytes != NULL;
}

static int parse(struct native_file *file, size_t size)
{
    const unsigned char *bytes = file->bytes;
    if (size < HEADER_SIZE || memcmp(bytes, MAGIC, sizeof MAGIC) || u32_at(bytes + 8) != FORMAT_VERSION ||
        u32_at(bytes + 12) != size || u32_at(bytes + 16) != crc32_of(bytes + 20, size - 20))
        return 1;
    const size_t blob = u32_at(bytes + 24), padded = (blob + 7u) & ~(size_t)7u, count = u32_at(bytes + 28);
    const size_t body = size - HEADER_SIZE;
    if (u32_at(bytes + 20) >= NATIVE_KINDS || blob > body || padded > body || count != (body - padded) / 8 ||
        (body - padded) % 8)
        return 1;
    file->kind = (enum native_kind)u32_at(bytes + 20);
    file->blob = bytes + HEADER_SIZE;
    file->blob_size = blob;
    file->settings = (const double *)(const void *)(bytes + HEADER_SIZE + padded);
    file->settings_count = count;
    return 0;
}

int native_file_read(struct native_file *file, const char *folder, struct text *error)
{
    size_t size = 0;
    memset(file, 0, sizeof *file);
    file->bytes = bytes_in(folder, &size);
    if (!file->bytes || parse(file, size)) {
        text_set(error, "%s/native.bin is %s; unpack or build the FMU again", folder,
                 file->bytes ? "damaged" : "missing");
        native_file_free(file);
        return 1;
    }
    return 0;
}

void native_file_free(struct native_file *file)
{
    free(file->bytes);
    file->bytes = NULL;
}

const double *native_file_take(struct native_file *file, size_t count)
{
    const double *taken = file->settings;
    if (file->settings_count < count)
        return NULL;
    file->settings += count;
    file->settings_count -= count;
    return taken;
}

/* Whether it is a whole number from 0 on, below an end. */
static int is_index(double value, double end)
{
    return value >= 0 && value < end && value == floor(value);
}

int native_file_take_indices(struct native_file *file, size_t end, size_t *count, const double **indices)
{
    const double *number = native_file_take(file, 1);
    if (!number || !is_index(number[0], (double)file->settings_count + 1))
        return 1;
    *count = (size_t)number[0];
    *indices = native_file_take(file, *count);
    for (size_t i = 0; i < *count; i++)
        if (!is_index((*indices)[i], (double)end))
            return 1;
    return 0;
}
