/* A device for docs/reference/hardware_protocol.md: the tasks of firmware, with BSD sockets.
 *
 *     cc -std=c99 -O2 -o device device.c -lm
 *     ./device 127.0.0.1 5005 SIGNATURE [KEY_FILE] [--fault broken:3@2.0]...
 *
 * make_controller.py prints the signature, which is computed from names and units of the signals. Memory is not allocated.
 * On a microcontroller, replace the robot, platform.h, the socket and the source of random numbers. */
#define _POSIX_C_SOURCE 200809L

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "simulated_robot.h" /* replace this by your hardware */
enum { HELLO_VALUES = 7, ACK_VALUES = 9, MAX_VALUES = ACK_VALUES + STATES };
#include "frame.h"
#include "platform.h"

static const double STEP = 1e-3, WATCHDOG = 0.02; /* [s] */
#ifndef PEER_TIMEOUT
#define PEER_TIMEOUT 1 /* [s] of silence after which another peer may replace a run in which nothing moves */
#endif

/* ---- The device: who may command the robot, when, and the watchdog */
static enum { IDLE, READY, RUNNING, IN_SAFE_STATE } state;
static struct sockaddr_in peer;
static uint32_t run, last_seq;
static uint64_t signature, nonce, last_heard;
static uint8_t secret[SHA256_BYTES]; /* of the nonces; new for each confirmed run */
static double agreed_step, agreed_watchdog, device_time;
static int lockstep, confirmed;
static struct packed answer, other; /* latest STATE; other answers */
static volatile sig_atomic_t ended;
static const uint64_t AWAKE = 50000; /* in [ns] */

static void go_safe(void)
{
    state = IN_SAFE_STATE;
    robot_safe();
}

static void watch(uint64_t now)
{
    if (state == RUNNING && !lockstep && (double)(now - last_heard) > agreed_watchdog * (double)SECOND)
        go_safe();
}

/* Complete the answer to a frame in place; count and values are already set. */
static const struct packed *complete_answer(struct frame *f, unsigned kind, uint64_t now, struct packed *to)
{
    f->kind = kind, f->echo = f->sent, f->sent = now, f->t = device_time;
    f->flags = (f->flags & CLAMPED) | (lockstep ? LOCKSTEP : 0) | (state == IN_SAFE_STATE ? SAFE : 0);
    pack(f, to);
    return to;
}

static int is_peer(const struct sockaddr_in *from)
{
    return from->sin_addr.s_addr == peer.sin_addr.s_addr && from->sin_port == peer.sin_port;
}

/* Set nonce and key of a run: always the same until a run is confirmed. */
static void derive_key(uint32_t number, const struct sockaddr_in *from)
{
    uint8_t parts[12], mac[SHA256_BYTES];
    put(parts, 4, number), put(parts + 4, 4, from->sin_addr.s_addr), put(parts + 8, 4, from->sin_port);
    hmac_sha256(secret, sizeof secret, parts, sizeof parts, mac);
    nonce = get(mac, 8);
    set_run_key(number, nonce);
}

/* Reserve the device for the current run, and let the nonces of other runs expire. */
static void confirm(uint64_t now)
{
    confirmed = 1, last_heard = now;
    if (read_file("/dev/urandom", secret, sizeof secret) != sizeof secret) /* from your hardware */
        put(secret, 8, get(secret, 8) + clock_ns());
}

static double shorter(double requested) { return requested > 0 && requested < WATCHDOG ? requested : WATCHDOG; }

/* Return why a requested run is impossible; 0 if it is possible. */
static unsigned hello_error(const struct frame *hello)
{
    const double *requested = hello->values, step = requested[2], steps = step / STEP;
    const int whole = steps > 0.5 && steps < 1000.5 && fabs(steps - floor(steps + 0.5)) < 1e-6 * steps;
    if (requested[0] != (double)(signature >> 32) || requested[1] != (double)(signature & 0xffffffffu) ||
        requested[5] != COMMANDS || requested[6] != STATES)
        return PORTS;
    if (requested[3] != 1)
        return WRONG_SCALE; /* values are in SI units */
    if (!(step > 0) || ((hello->flags & LOCKSTEP) && !whole))
        return WRONG_STEP;
    return !(hello->flags & LOCKSTEP) && shorter(requested[4]) < 2 * step ? SHORT_WATCHDOG : 0;
}

static void begin(const struct frame *hello, const struct sockaddr_in *from, uint64_t now)
{
    derive_key(hello->run, from);
    confirmed = 0, run = hello->run, peer = *from, last_seq = 0, device_time = 0, answer.size = 0;
    lockstep = (hello->flags & LOCKSTEP) != 0;
    agreed_step = hello->values[2], agreed_watchdog = shorter(hello->values[4]);
    state = READY, robot_reset();
    if (!key_size)
        confirm(now); /* with a key, the hello may be a copy, and the next frame confirms the run */
}

static const struct packed *handle_hello(struct frame *f, const struct sockaddr_in *from, uint64_t now)
{
    const int known = state != IDLE && f->run == run && is_peer(from);
    const int at_rest = state == READY || (state == RUNNING && lockstep);
    const int is_free = state == IDLE || state == IN_SAFE_STATE || (state == READY && is_peer(from) && !key_size) ||
                        (at_rest && (!confirmed || now > last_heard + PEER_TIMEOUT * SECOND));
    if (f->run == 0 || f->count != HELLO_VALUES || (known && state != READY))
        return NULL; /* invalid, or a late copy of an earlier run */
    const unsigned reason = known ? 0 : is_free ? hello_error(f) : BUSY;
    if (reason) {
        f->count = 1, f->values[0] = reason;
        return complete_answer(f, ERROR, now, &other);
    }
    if (!known)
        begin(f, from, now); /* a repeated hello does not reset the watchdog: it may be a copy */
    f->values[4] = agreed_watchdog;
    f->values[7] = (double)(nonce >> 32), f->values[8] = (double)(nonce & 0xffffffffu);
    robot_state(f->values + ACK_VALUES);
    f->count = ACK_VALUES + STATES;
    return complete_answer(f, HELLO_ACK, now, &other);
}

static const struct packed *handle_setpoint(struct frame *f, uint64_t now)
{
    const uint32_t ahead = f->seq - last_seq; /* modulo 2^32 */
    if (f->count != COMMANDS)
        return NULL;
    if (lockstep && ahead == 0 && answer.size)
        return &answer; /* the answer was lost: send it again, without another step */
    if (ahead == 0 || ahead >= 0x80000000u)
        return NULL; /* a copy, or older than the last one */
    last_seq = f->seq, f->flags = 0;
    if (state != IN_SAFE_STATE) {
        last_heard = now, state = RUNNING;
        for (int i = 0; i < COMMANDS; i++) {
            const double force = f->values[i];
            const double within = force < F_MIN ? F_MIN : force > F_MAX ? F_MAX : force;
            f->flags |= within != force ? CLAMPED : 0;
            robot_apply(i, within);
        }
        if (lockstep)
            robot_advance(agreed_step), device_time += agreed_step;
    }
    robot_state(f->values);
    f->count = STATES;
    return complete_answer(f, STATE, now, &answer);
}

/* Process a received frame. Return the answer, or NULL. */
static const struct packed *receive(const uint8_t *data, size_t size,
                                    const struct sockaddr_in *from, uint64_t now)
{
    static struct frame f;
    watch(now);
    const int offers = state == READY && !confirmed;
    if (offers && size >= HEADER)
        derive_key((uint32_t)get(data + 8, 4), from);
    if (!unpack(data, size, &f))
        return NULL;
    if (f.kind == HELLO)
        return handle_hello(&f, from, now);
    if (offers && f.kind == PING && f.count == HELLO_VALUES && (f.run != run || !is_peer(from)) && !hello_error(&f))
        begin(&f, from, now); /* another hello, possibly a copy, has replaced this run */
    if (state == IDLE || f.run != run || !is_peer(from))
        return NULL;
    if (!confirmed)
        confirm(now);
    if (f.kind == SETPOINT)
        return handle_setpoint(&f, now);
    f.flags = 0;
    if (f.kind == STOP)
        go_safe();
    return f.kind == STOP ? complete_answer(&f, STOPPED, now, &other)
           : f.kind == PING ? complete_answer(&f, PONG, now, &other) : NULL;
}

static void end(int number) { ended = number; }

static void serve(int line)
{
    const uint64_t step = (uint64_t)(STEP * (double)SECOND);
    uint64_t reached = clock_ns();
    while (!ended) {
        uint64_t now = clock_ns();
        if (now - reached > SECOND / 20)
            reached = now - step; /* after a delay, lost time is not caught up in a burst */
        for (; reached + step <= now; reached += step)
            if (!lockstep && (state == RUNNING || state == IN_SAFE_STATE))
                robot_advance(STEP), device_time += STEP;
        watch(now);
        fd_set readable;
        FD_ZERO(&readable);
        FD_SET(line, &readable);
        const struct timespec wait = {0, (long)(reached + step - now)};
        /* In lockstep the next set point comes soon; sleeping and waking up would take longer. */
        const int awake = lockstep && state == RUNNING && now - last_heard < AWAKE;
        if (!awake && pselect(line + 1, &readable, NULL, NULL, &wait, NULL) <= 0)
            continue;
        static uint8_t data[sizeof answer.bytes + 1];
        struct sockaddr_in from;
        socklen_t size = sizeof from;
        const ssize_t got = recvfrom(line, data, sizeof data, 0, (struct sockaddr *)&from, &size);
        const struct packed *reply = got < 0 ? NULL : receive(data, (size_t)got, &from, clock_ns());
        if (reply)
            (void)sendto(line, reply->bytes, reply->size, 0, (struct sockaddr *)&from, size);
    }
    go_safe();
}

int main(int count, char **arguments)
{
    struct sockaddr_in here = {0};
    socklen_t size = sizeof here;
    here.sin_family = AF_INET;
    const int line = socket(AF_INET, SOCK_DGRAM, 0);
    for (; count > 5 && !strcmp(arguments[count - 2], "--fault"); count -= 2)
        if (!failures_add(arguments[count - 1]))
            return fprintf(stderr, "device: --fault must be KIND:NUMBER[=VALUE]@TIME, such as broken:3@2.0, not %s; " KINDS_TEXT "\n",
                           arguments[count - 1]), 2;
    if (count < 4 || inet_pton(AF_INET, arguments[1], &here.sin_addr) != 1 || line < 0)
        return fprintf(stderr, "usage: device ADDRESS PORT SIGNATURE [KEY_FILE] [--fault KIND:NUMBER[=VALUE]@TIME]...\n"), 2;
    here.sin_port = htons((uint16_t)strtoul(arguments[2], NULL, 10));
    signature = strtoull(arguments[3], NULL, 16);
    if (count > 4) {
        key_size = read_file(arguments[4], pre_shared, sizeof pre_shared);
        if (key_size < 16 || key_size > MAX_KEY)
            return fprintf(stderr, "device: no key of 16 to 256 bytes in %s\n", arguments[4]), 2;
    }
    if (fcntl(line, F_SETFL, O_NONBLOCK) < 0 ||
        bind(line, (struct sockaddr *)&here, sizeof here) < 0 ||
        getsockname(line, (struct sockaddr *)&here, &size) < 0)
        return perror("device: cannot listen on this address"), 2;
    if (!key_size && ntohl(here.sin_addr.s_addr) >> 24 != 127)
        fprintf(stderr, "device: without a key, anyone on the network can command the robot\n");
    signal(SIGINT, end), signal(SIGTERM, end), robot_reset(), confirm(0);
    printf("udp://%s:%u\n", arguments[1], (unsigned)ntohs(here.sin_port)), fflush(stdout);
    serve(line);
    return 0;
}
