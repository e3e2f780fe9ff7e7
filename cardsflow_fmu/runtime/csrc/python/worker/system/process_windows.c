#ifdef _WIN32

#include "process.h"

#include "../../../platform/wide.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

/* Quote an argument: backslashes are special only before a quote. Return the end of the written text. */
static char *quote(char *out, const char *argument)
{
    size_t backslashes = 0;
    *out++ = '"';
    for (; *argument; argument++) {
        if (*argument == '"')
            for (backslashes++; backslashes; backslashes--)
                *out++ = '\\';
        backslashes = *argument == '\\' ? backslashes + 1 : 0;
        *out++ = *argument;
    }
    for (; backslashes; backslashes--)
        *out++ = '\\';
    *out++ = '"';
    *out++ = ' ';
    return out;
}

/* Return the whole command line, on the heap. */
static wchar_t *command_line(const char *program, const char *const arguments[], const char *last)
{
    size_t size = 2 * (strlen(program) + strlen(last)) + 8;
    for (size_t i = 0; arguments[i]; i++)
        size += 2 * strlen(arguments[i]) + 4;
    char *line = malloc(size);
    if (!line)
        return NULL;
    char *at = quote(line, program);
    for (size_t i = 0; arguments[i]; i++)
        at = quote(at, arguments[i]);
    at = quote(at, last);
    at[-1] = '\0';
    wchar_t *wide = wide_from_utf8(line);
    free(line);
    return wide;
}

/* Create a job that ends the process when this process ends and its handle is closed. */
static HANDLE make_job(void)
{
    JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits;
    HANDLE job = CreateJobObjectW(NULL, NULL);
    memset(&limits, 0, sizeof limits);
    limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE;
    if (job)
        SetInformationJobObject(job, JobObjectExtendedLimitInformation, &limits, sizeof limits);
    return job;
}

/* Handles that the started process inherits, in the order of its arguments. */
enum { OWN_EVENT, HOST_EVENT, HOST_PROCESS, MEMORY, HANDLES };

static int make_handles(HANDLE handles[HANDLES], const struct shared_memory *memory)
{
    SECURITY_ATTRIBUTES inherited = {sizeof inherited, NULL, TRUE};
    HANDLE self = GetCurrentProcess();
    handles[OWN_EVENT] = CreateEventW(&inherited, FALSE, FALSE, NULL);
    handles[HOST_EVENT] = CreateEventW(&inherited, FALSE, FALSE, NULL);
    handles[MEMORY] = memory->handle;
    handles[HOST_PROCESS] = NULL;
    DuplicateHandle(self, self, self, &handles[HOST_PROCESS], SYNCHRONIZE, TRUE, 0);
    return !handles[OWN_EVENT] || !handles[HOST_EVENT] || !handles[HOST_PROCESS];
}

static int create(wchar_t *line, HANDLE handles[HANDLES], PROCESS_INFORMATION *created)
{
    STARTUPINFOEXW start;
    SIZE_T size = 0;
    memset(&start, 0, sizeof start);
    start.StartupInfo.cb = sizeof start;
    InitializeProcThreadAttributeList(NULL, 1, 0, &size);
    start.lpAttributeList = malloc(size);
    if (!start.lpAttributeList)
        return 0;
    int done = 0;
    if (InitializeProcThreadAttributeList(start.lpAttributeList, 1, 0, &size)) {
        done = UpdateProcThreadAttribute(start.lpAttributeList, 0,
                                         PROC_THREAD_ATTRIBUTE_HANDLE_LIST, handles,
                                         HANDLES * sizeof *handles, NULL, NULL) &&
               CreateProcessW(NULL, line, NULL, NULL, TRUE,
                              EXTENDED_STARTUPINFO_PRESENT | CREATE_NO_WINDOW | CREATE_SUSPENDED,
                              NULL, NULL, &start.StartupInfo, created);
        DeleteProcThreadAttributeList(start.lpAttributeList);
    }
    free(start.lpAttributeList);
    return done;
}

static void close_handles(HANDLE handles[HANDLES])
{
    for (int i = OWN_EVENT; i <= HOST_PROCESS; i++)
        if (handles[i])
            CloseHandle(handles[i]);
}

static unsigned long long number(HANDLE handle)
{
    return (unsigned long long)(uintptr_t)handle;
}

int process_start(struct process *process, const char *program, const char *const arguments[],
                  const struct shared_memory *memory, struct text *error)
{
    HANDLE handles[HANDLES];
    PROCESS_INFORMATION created;
    char links[128];
    wchar_t *line = NULL;
    int done = make_handles(handles, memory) == 0;
    if (done) {
        snprintf(links, sizeof links, "%llu:%llu:%llu:%llu:%llu", number(handles[OWN_EVENT]),
                 number(handles[HOST_EVENT]), number(handles[HOST_PROCESS]),
                 number(handles[MEMORY]), (unsigned long long)memory->size);
        line = command_line(program, arguments, links);
        done = line && create(line, handles, &created);
    }
    free(line);
    if (!done) {
        text_set(error, "cannot be started: Windows error %lu", (unsigned long)GetLastError());
        close_handles(handles);
        return 1;
    }
    process->job = make_job();
    if (process->job)
        AssignProcessToJobObject(process->job, created.hProcess);
    ResumeThread(created.hThread);
    CloseHandle(created.hThread);
    CloseHandle(handles[HOST_PROCESS]);
    process->handle = created.hProcess;
    process->bell.mine = handles[HOST_EVENT];
    process->bell.others = handles[OWN_EVENT];
    process->bell.peer = NULL;
    HANDLE self = GetCurrentProcess();
    DuplicateHandle(self, created.hProcess, self, &process->bell.peer, SYNCHRONIZE, FALSE, 0);
    process->is_running = 1;
    return 0;
}

int process_has_ended(struct process *process, double seconds, struct text *how)
{
    DWORD code = 0;
    if (WaitForSingleObject(process->handle, (DWORD)(seconds * 1000)) != WAIT_OBJECT_0)
        return 0;
    process->is_running = 0;
    GetExitCodeProcess(process->handle, &code);
    text_set(how, "has ended with exit code %lu", (unsigned long)code);
    return 1;
}

int process_is_child(const struct process *process)
{
    (void)process; /* fork does not exist */
    return 1;
}

void process_end(struct process *process, double patience)
{
    enum { MAX_KILL = 5000 };
    if (WaitForSingleObject(process->handle, (DWORD)(patience * 1000)) != WAIT_OBJECT_0) {
        if (process->job)
            TerminateJobObject(process->job, 1);
        TerminateProcess(process->handle, 1);
        WaitForSingleObject(process->handle, MAX_KILL);
    }
    process->is_running = 0;
    CloseHandle(process->handle);
    if (process->job)
        CloseHandle(process->job);
    bell_close(&process->bell);
}

static DWORD WINAPI watch_host(void *host)
{
    WaitForSingleObject(host, INFINITE);
    ExitProcess(1);
    return 0;
}

int process_attach(const char *argument, struct shared_memory *memory, struct bell *bell)
{
    unsigned long long numbers[HANDLES], size;
    if (sscanf(argument, "%llu:%llu:%llu:%llu:%llu", &numbers[OWN_EVENT], &numbers[HOST_EVENT],
               &numbers[HOST_PROCESS], &numbers[MEMORY], &size) != HANDLES + 1)
        return 1;
    bell->mine = (HANDLE)(uintptr_t)numbers[OWN_EVENT];
    bell->others = (HANDLE)(uintptr_t)numbers[HOST_EVENT];
    bell->peer = (HANDLE)(uintptr_t)numbers[HOST_PROCESS];
    memory->handle = (HANDLE)(uintptr_t)numbers[MEMORY];
    memory->size = (size_t)size;
    if (shared_memory_map(memory))
        return 1;
    HANDLE thread = CreateThread(NULL, 0, watch_host, bell->peer, 0, NULL);
    if (thread)
        CloseHandle(thread);
    return thread == NULL;
}

char *process_own_library(void)
{
    enum { MAX_WIDE_PATH = 32768 };
    HMODULE module = NULL;
    wchar_t *wide = malloc(MAX_WIDE_PATH * sizeof *wide);
    char *path = NULL;
    if (wide &&
        GetModuleHandleExW(GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS |
                           GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT,
                           (const wchar_t *)(const void *)make_job, &module) &&
        GetModuleFileNameW(module, wide, MAX_WIDE_PATH))
        path = utf8_from_wide(wide);
    free(wide);
    return path;
}

#endif
