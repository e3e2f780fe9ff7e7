#ifdef _WIN32

#include "shared_memory.h"

#include <windows.h>

int shared_memory_map(struct shared_memory *memory)
{
    memory->bytes = MapViewOfFile(memory->handle, FILE_MAP_ALL_ACCESS, 0, 0, memory->size);
    return memory->bytes == NULL;
}

int shared_memory_create(struct shared_memory *memory, size_t size, struct text *error)
{
    SECURITY_ATTRIBUTES inherited = {sizeof inherited, NULL, TRUE};
    memory->bytes = NULL;
    memory->size = size;
    memory->handle =
        CreateFileMappingW(INVALID_HANDLE_VALUE, &inherited, PAGE_READWRITE,
                           (DWORD)((unsigned long long)size >> 32), (DWORD)size, NULL);
    if (memory->handle && shared_memory_map(memory) == 0)
        return 0;
    text_set(error, "no shared memory of %lu bytes: Windows error %lu",
             (unsigned long)size, (unsigned long)GetLastError());
    shared_memory_close(memory);
    return 1;
}

void shared_memory_close(struct shared_memory *memory)
{
    if (memory->bytes)
        UnmapViewOfFile(memory->bytes);
    if (memory->handle)
        CloseHandle(memory->handle);
    memory->bytes = NULL;
    memory->handle = NULL;
}

#endif
