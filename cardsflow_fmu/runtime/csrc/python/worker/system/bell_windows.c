#ifdef _WIN32

#include "bell.h"

#include <windows.h>

void bell_ring(const struct bell *bell)
{
    SetEvent(bell->others);
}

enum bell_answer bell_wait(const struct bell *bell, double seconds)
{
    HANDLE watched[] = {bell->mine, bell->peer};
    switch (WaitForMultipleObjects(2, watched, FALSE, (DWORD)(seconds * 1000 + 0.999))) {
    case WAIT_OBJECT_0:
        return BELL_RUNG;
    case WAIT_TIMEOUT:
        return BELL_SILENT;
    default:
        return BELL_GONE;
    }
}

static void close_handle(void **handle)
{
    if (*handle)
        CloseHandle(*handle);
    *handle = NULL;
}

void bell_close(struct bell *bell)
{
    close_handle(&bell->mine);
    close_handle(&bell->others);
    close_handle(&bell->peer);
}

#endif
