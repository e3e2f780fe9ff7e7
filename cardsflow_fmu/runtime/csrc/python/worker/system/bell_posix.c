#ifndef _WIN32

#include "bell.h"

#include <errno.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#ifdef MSG_NOSIGNAL
enum { SEND_FLAGS = MSG_DONTWAIT | MSG_NOSIGNAL };
#else /* macOS: the socket has SO_NOSIGPIPE */
enum { SEND_FLAGS = MSG_DONTWAIT };
#endif

void bell_ring(const struct bell *bell)
{
    ssize_t sent;
    do
        sent = send(bell->socket, "!", 1, SEND_FLAGS);
    while (sent < 0 && errno == EINTR);
}

/* Receive all stored rings. Return whether the other process has ended. */
static int drain(int socket)
{
    char rings[64];
    for (;;) {
        ssize_t received = recv(socket, rings, sizeof rings, MSG_DONTWAIT);
        if (received < 0 && errno == EINTR)
            continue;
        if (received < (ssize_t)sizeof rings)
            return received == 0 || (received < 0 && errno != EAGAIN && errno != EWOULDBLOCK);
    }
}

enum bell_answer bell_wait(const struct bell *bell, double seconds)
{
    struct pollfd watched = {bell->socket, POLLIN, 0};
    int count = poll(&watched, 1, (int)(seconds * 1000 + 0.999));
    if (count == 0 || (count < 0 && errno == EINTR))
        return BELL_SILENT;
    return count < 0 || drain(bell->socket) ? BELL_GONE : BELL_RUNG;
}

void bell_close(struct bell *bell)
{
    if (bell->socket >= 0)
        close(bell->socket);
    bell->socket = -1;
}

#endif
