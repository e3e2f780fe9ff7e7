#ifndef _WIN32

#include "process.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#ifdef __APPLE__
#include <crt_externs.h>
#define environ (*_NSGetEnviron())
#else
extern char **environ;
#endif

/* File descriptors of the started process: no input, output and errors as in this process, and these. */
enum { BELL_NUMBER = 3, MEMORY_NUMBER = 4, FIRST_FREE = 5 };

/* Return a copy of a file with a number outside of this range, which the process does not inherit. */
static int move_up(int file)
{
    int moved = file < 0 ? -1 : fcntl(file, F_DUPFD_CLOEXEC, FIRST_FREE);
    if (file >= 0)
        close(file);
    return moved;
}

static int open_sockets(int sockets[2])
{
#ifdef SOCK_CLOEXEC
    int failed = socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets);
#else
    int failed = socketpair(AF_UNIX, SOCK_STREAM, 0, sockets);
#endif
    if (failed)
        return 1;
    for (int i = 0; i < 2; i++) {
        sockets[i] = move_up(sockets[i]);
#ifdef SO_NOSIGPIPE
        int on = 1;
        setsockopt(sockets[i], SOL_SOCKET, SO_NOSIGPIPE, &on, sizeof on);
#endif
    }
    if (sockets[0] >= 0 && sockets[1] >= 0)
        return 0;
    for (int i = 0; i < 2; i++)
        if (sockets[i] >= 0)
            close(sockets[i]);
    return 1;
}

/* If the host has no output or errors, their descriptors are closed, and the next file would get these
 * numbers. */
static int add_output(posix_spawn_file_actions_t *files, int number)
{
    if (fcntl(number, F_GETFD) >= 0)
        return 0;
    return posix_spawn_file_actions_addopen(files, number, "/dev/null", O_WRONLY, 0);
}

static int add_files(posix_spawn_file_actions_t *files, int bell, int memory)
{
    return add_output(files, STDOUT_FILENO) || add_output(files, STDERR_FILENO) ||
           posix_spawn_file_actions_addopen(files, STDIN_FILENO, "/dev/null", O_RDONLY, 0) ||
           posix_spawn_file_actions_adddup2(files, bell, BELL_NUMBER) ||
           posix_spawn_file_actions_adddup2(files, memory, MEMORY_NUMBER);
}

/* Unblock all signals, and send Ctrl-C of the terminal to the host only. */
static int set_attributes(posix_spawnattr_t *attributes)
{
    sigset_t none;
    sigemptyset(&none);
    return posix_spawnattr_setsigmask(attributes, &none) ||
           posix_spawnattr_setpgroup(attributes, 0) ||
           posix_spawnattr_setflags(attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
}

/* Return 0, or an error number. */
static int spawn(pid_t *id, char *const arguments[], int bell, int memory)
{
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    if (posix_spawn_file_actions_init(&files))
        return ENOMEM;
    int failed = posix_spawnattr_init(&attributes) ? ENOMEM : 0;
    if (!failed) {
        failed = add_files(&files, bell, memory) || set_attributes(&attributes) ? ENOMEM : 0;
        if (!failed)
            failed = posix_spawnp(id, arguments[0], &files, &attributes, arguments, environ);
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&files);
    return failed;
}

/* Return the whole command line, on the heap. The system function requires a writable one, but does not
 * modify it. */
static char **command_line(const char *program, const char *const arguments[], const char *last)
{
    size_t count = 0;
    while (arguments[count])
        count++;
    char **all = calloc(count + 3, sizeof *all);
    if (!all)
        return NULL;
    all[0] = (char *)program;
    for (size_t i = 0; i < count; i++)
        all[i + 1] = (char *)arguments[i];
    all[count + 1] = (char *)last;
    return all;
}

int process_start(struct process *process, const char *program, const char *const arguments[],
                  const struct shared_memory *memory, struct text *error)
{
    int sockets[2];
    char links[64];
    pid_t id = 0;
    snprintf(links, sizeof links, "%ld:%lu", (long)getpid(), (unsigned long)memory->size);
    char **all = command_line(program, arguments, links);
    int failed = !all ? ENOMEM : open_sockets(sockets) ? errno : 0;
    if (!failed) {
        int handle = fcntl(memory->handle, F_DUPFD_CLOEXEC, FIRST_FREE);
        failed = handle < 0 ? errno : spawn(&id, all, sockets[1], handle);
        if (handle >= 0)
            close(handle);
        close(sockets[1]);
        if (failed)
            close(sockets[0]);
    }
    free(all);
    if (failed) {
        text_set(error, "cannot be started: %s", strerror(failed));
        return 1;
    }
    process->bell.socket = sockets[0];
    process->id = id;
    process->owner = getpid();
    process->is_running = 1;
    return 0;
}

/* Collect the exit status of the process, if it has ended or `options` request to wait. If the host collects
 * the status of all its children, the status is unknown. */
static int reap(struct process *process, int options)
{
    pid_t ended;
    do
        ended = waitpid((pid_t)process->id, &process->status, options);
    while (ended < 0 && errno == EINTR);
    if (ended == 0)
        return 0;
    if (ended < 0)
        process->status = 0;
    process->is_running = 0;
    return 1;
}

int process_has_ended(struct process *process, double seconds, struct text *how)
{
    enum { GLANCE = 5 }; /* in ms */
    while (process->is_running && !reap(process, WNOHANG)) {
        if (seconds <= 0)
            return 0;
        poll(NULL, 0, GLANCE);
        seconds -= 1e-3 * GLANCE;
    }
    if (WIFSIGNALED(process->status))
        text_set(how, "was ended by signal %d", WTERMSIG(process->status));
    else
        text_set(how, "has ended with exit code %d", WEXITSTATUS(process->status));
    return 1;
}

int process_is_child(const struct process *process)
{
    return process->owner == (long)getpid();
}

void process_end(struct process *process, double patience)
{
    struct text how = {NULL};
    if (process_is_child(process) && !process_has_ended(process, patience, &how)) {
        kill((pid_t)process->id, SIGKILL);
        reap(process, 0);
    }
    text_free(&how);
    bell_close(&process->bell);
}

/* End this process when the host closes its end or is no longer the parent, since a forked copy of the host
 * may keep the socket open. */
static void *watch_host(void *argument)
{
    long host = (long)(size_t)argument;
    for (;;) {
        struct pollfd watched = {BELL_NUMBER, 0, 0};
        int count = poll(&watched, 1, 1000);
        if ((count > 0 && watched.revents) || (long)getppid() != host)
            _exit(1);
    }
    return NULL;
}

int process_attach(const char *argument, struct shared_memory *memory, struct bell *bell)
{
    long host;
    unsigned long size;
    pthread_t thread;
    sigset_t all, before;
    if (sscanf(argument, "%ld:%lu", &host, &size) != 2)
        return 1;
    bell->socket = BELL_NUMBER;
    memory->handle = MEMORY_NUMBER;
    memory->size = size;
    fcntl(BELL_NUMBER, F_SETFD, FD_CLOEXEC);
    fcntl(MEMORY_NUMBER, F_SETFD, FD_CLOEXEC);
    if (shared_memory_map(memory))
        return 1;
    sigfillset(&all); /* only the Python thread handles signals */
    pthread_sigmask(SIG_BLOCK, &all, &before);
    int failed = pthread_create(&thread, NULL, watch_host, (void *)(size_t)host);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (!failed)
        pthread_detach(thread);
    return failed;
}

char *process_own_library(void)
{
    Dl_info info;
    char *(*function)(void) = process_own_library;
    void *address;
    memcpy(&address, &function, sizeof address);
    if (!dladdr(address, &info) || !info.dli_fname)
        return NULL;
    return realpath(info.dli_fname, NULL);
}

#endif
