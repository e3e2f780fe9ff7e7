#include "read_file.h"

#include "text.h"

#include <stdio.h>
#include <stdlib.h>

#ifdef _WIN32
#include "wide.h"

static FILE *open_file(const char *path)
{
    wchar_t *wide = wide_from_utf8(path);
    FILE *file = wide ? _wfopen(wide, L"rb") : NULL;
    free(wide);
    return file;
}
#else
static FILE *open_file(const char *path)
{
    return fopen(path, "rb");
}
#endif

static unsigned char *read_all(FILE *file, size_t *size)
{
    long length = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    if (length < 0 || fseek(file, 0, SEEK_SET) != 0)
        return NULL;
    unsigned char *bytes = malloc((size_t)length + 1);
    if (bytes && fread(bytes, 1, (size_t)length, file) != (size_t)length) {
        free(bytes);
        return NULL;
    }
    if (bytes)
        bytes[length] = '\0';
    *size = (size_t)length;
    return bytes;
}

unsigned char *read_file(const char *folder, const char *name, size_t *size)
{
    struct text path = {NULL};
    text_set(&path, "%s/%s", folder, name);
    FILE *file = open_file(text_get(&path));
    text_free(&path);
    if (!file)
        return NULL;
    unsigned char *bytes = read_all(file, size);
    fclose(file);
    return bytes;
}
