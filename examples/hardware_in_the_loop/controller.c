/* A controller that speaks docs/reference/hardware_protocol.md: the other side of device.c, without any Python.
 *
 * A computed-torque law ticks: the state comes by UDP, the forces go back. make_controller.py writes robot.h
 * and the reference of an experiment:
 *
 *     python make_controller.py ../planar_2r build
 *     cc -std=c99 -O2 -ffp-contract=off -DCARDSFLOW_INSIDE -Ibuild controller.c \
 *         $(find ../../sim_dart/csrc ../../controllers/csrc -name "*.c" \
 *             ! -path "*freestanding*" ! -path "*tangent*") -o build/controller -lm
 *     build/controller 127.0.0.1 5005 realtime < build/reference.f64 > run.csv
 *
 * For a processor whose floating point unit knows single precision only, with the law compiled so, write
 * robot.h by `make_controller.py --single` and add what compiles for single precision:
 *
 *     gcc -DCARDSFLOW_FLOAT -fsingle-precision-constant ...
 *
 * Where the experiment has an [estimator], q and qd are estimated from lengths and tensions: robot_estimator.h.
 * Nothing is allocated. What a microcontroller exchanges is the clock, the socket and the source of chance. */
#define _POSIX_C_SOURCE 200809L

#include "robot_estimator.h"

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

enum { COMMANDS = MUSCLES, STATES = 2 * COORDINATES + 2 * MUSCLES, ROWS = TASKS ? TASKS : COORDINATES };
enum { HELLO_VALUES = 7, ACK_VALUES = 9, MAX_VALUES = ACK_VALUES + STATES };
#include "frame.h"

static const uint64_t SECOND = 1000000000, REPEAT = 20000000;  /* [ns] */
static const double PATIENCE = 0.6, RAMP_DOWN = 0.5, NEAR = 0.1; /* part of a step, [s], [rad] or [m] */
enum { HELLOS = 40, STOPS = 10 };
#ifndef MAX_MISSED
#define MAX_MISSED 10 /* answers in a row, in real time */
#endif

/* ---- The link: one frame there, one back */
static int line, lockstep;
static uint32_t run, seq;
static uint64_t origin; /* when the run began */
static double state[STATES], forces[MUSCLES]; /* the newest; what was commanded last */
static real load[COORDINATES];
static struct frame f;
static struct packed sent;
static volatile sig_atomic_t ended;

static int most_missed(void) { return lockstep ? 0 : MAX_MISSED; }

static void end(int number) { ended = number; }

static uint64_t clock_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * SECOND + (uint64_t)t.tv_nsec;
}

static void say(unsigned kind, double t, const double *values, unsigned count)
{
    f.kind = kind, f.flags = lockstep ? LOCKSTEP : 0, f.count = count;
    f.run = run, f.seq = seq, f.t = t, f.sent = clock_ns(), f.echo = 0;
    if (count)
        memcpy(f.values, values, count * sizeof *values);
    pack(&f, &sent);
    (void)send(line, sent.bytes, sent.size, 0);
}

/* Whether a frame of this run and one of two kinds came until then; it is in `f`. */
static int hear(unsigned kind, unsigned other, uint64_t until)
{
    static uint8_t data[sizeof sent.bytes + 1];
    for (;;) {
        const ssize_t got = recv(line, data, sizeof data, MSG_DONTWAIT);
        if (got >= 0 && unpack(data, (size_t)got, &f) && f.run == run && (f.kind == kind || f.kind == other))
            return 1;
        const uint64_t now = clock_ns();
        if (now >= until)
            return 0;
        fd_set readable;
        FD_ZERO(&readable);
        FD_SET(line, &readable);
        const struct timespec wait = {(time_t)((until - now) / SECOND), (long)((until - now) % SECOND)};
        (void)pselect(line + 1, &readable, NULL, NULL, &wait, NULL);
    }
}

static size_t read_file(const char *name, void *to, size_t size)
{
    const int file = open(name, O_RDONLY);
    const ssize_t got = read(file, to, size);
    close(file);
    return got < 0 ? 0 : (size_t)got;
}

static int is_half(double half) { return half >= 0 && half < 4294967296.0 && half == floor(half); }

/* Takes the run that the device has agreed to, in a HELLO_ACK; whether it is one. */
static int begin(void)
{
    uint8_t both[12]; /* the run's number and the device's, of which the run's key is made */
    if (f.count != ACK_VALUES + STATES || !is_half(f.values[7]) || !is_half(f.values[8]))
        return 0;
    put(both, 4, run);
    put(both + 4, 8, (uint64_t)f.values[7] << 32 | (uint64_t)f.values[8]);
    hmac_sha256(pre_shared, key_size, both, sizeof both, run_key);
    memcpy(state, f.values + ACK_VALUES, sizeof state);
    origin = clock_ns();
    return 1;
}

/* Whether the device agrees to a run; then `state` is its own. */
static int greet(void)
{
    const double wish[HELLO_VALUES] = {SIGNATURE_HIGH, SIGNATURE_LOW, STEP, 1, 0, COMMANDS, STATES};
    if (read_file("/dev/urandom", &run, sizeof run) != sizeof run || !run)
        run = (uint32_t)clock_ns() | 1;
    for (int k = 0; k < HELLOS && !ended; k++) {
        say(HELLO, 0, wish, HELLO_VALUES);
        if (!hear(HELLO_ACK, ERROR, clock_ns() + SECOND / 20))
            continue;
        if (f.kind == HELLO_ACK && begin())
            return 1;
        if (f.kind != ERROR || f.count != 1 || f.values[0] != BUSY)
            return fprintf(stderr, "controller: the device refuses; see the protocol's codes\n"), 0;
    }
    return fprintf(stderr, "controller: nobody answers, or it is in use\n"), 0;
}

/* Whether a new state came: in lockstep what is lost is sent again, in real time it is missed. */
static int exchange(double t)
{
    const uint64_t begin = clock_ns(), patience = (uint64_t)(PATIENCE * STEP * (double)SECOND);
    const uint64_t until = begin + (lockstep ? SECOND : patience);
    seq++;
    say(SETPOINT, t, forces, COMMANDS);
    while (!ended && clock_ns() < until) {
        const uint64_t again = clock_ns() + REPEAT;
        if (!hear(STATE, STATE, again < until ? again : until)) {
            (void)(lockstep && send(line, sent.bytes, sent.size, 0));
        } else if (f.seq == seq && f.count == STATES) {
            memcpy(state, f.values, sizeof state);
            return 1;
        }
    }
    return 0;
}

/* In real time, waits for time t of the run. Who is late by more than a step slips: no burst follows. */
static void pace(double t)
{
    const uint64_t due = origin + (uint64_t)(t * (double)SECOND), now = clock_ns();
    const struct timespec until = {(time_t)(due / SECOND), (long)(due % SECOND)};
    if (now > due + (uint64_t)(STEP * (double)SECOND))
        origin += now - due;
    else if (!lockstep)
        while (!ended && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL))
            ;
}

static void ramp_down(long tick)
{
    const long steps = (long)(RAMP_DOWN / STEP + 0.5);
    double top[MUSCLES];
    memcpy(top, forces, sizeof top);
    ended = 0; /* a second Ctrl-C cuts it short */
    for (long left = steps, missed = 0; left-- && !ended && missed <= most_missed(); tick++) {
        for (int i = 0; i < MUSCLES; i++)
            forces[i] = F_MIN[i] + (double)left / (double)steps * (top[i] - F_MIN[i]);
        pace((double)tick * STEP);
        missed = exchange((double)tick * STEP) ? 0 : missed + 1;
    }
}

/* Tells the device to stop, until it says that it has. */
static void stop(void)
{
    for (int k = 0; k < STOPS; k++) {
        say(STOP, 0, NULL, 0);
        if (hear(STOPPED, STOPPED, clock_ns() + REPEAT))
            return;
    }
}

/* ---- The run */
static void show(double t)
{
    printf("%.17g", t);
    for (int j = 0; j < COORDINATES; j++)
        printf(",%.17g", state[j]);
    for (int i = 0; i < MUSCLES; i++)
        printf(",%.17g", forces[i]);
    putchar('\n');
}

/* Position, velocity and acceleration of the next tick; 0 at the end. */
static int next_reference(double *reference)
{
    uint8_t *to = (uint8_t *)reference;
    size_t left = 3 * ROWS * sizeof(double);
    for (ssize_t got = 1; left && got > 0; left -= (size_t)got, to += got)
        got = read(STDIN_FILENO, to, left);
    return !left;
}

static int is_near(void)
{
    for (int j = 0; j < COORDINATES; j++)
        if (!(fabs(state[j] - START[j]) <= NEAR))
            return 0;
    return 1;
}

static int are_finite(const double *found)
{
    for (int i = 0; i < MUSCLES; i++)
        if (!isfinite(found[i]))
            return 0;
    return 1;
}

/* What went wrong; NULL for nothing. Forces that somebody still follows fall slowly in the end. */
static const char *drive(void)
{
    double reference[3 * ROWS], found[MUSCLES];
    long tick = 0;
    const char *wrong = NULL;
    int is_known = 1;
    for (int missed = 0; !ended && !wrong && is_known && next_reference(reference); tick++) {
        const double t = (double)tick * STEP;
        pace(t);
        if (tick_law(STEP, state, reference, load, found) >= COMPUTED_TORQUE_FAILED || !are_finite(found)) {
            wrong = "no forces are found";
            break;
        }
        memcpy(forces, found, sizeof forces);
        show(t);
        missed = exchange(t) ? 0 : missed + 1;
        if (missed > most_missed())
            return "the device is lost";
        if (!missed && f.flags & SAFE)
            return "the device has gone to its safe state";
        is_known = estimate(state, !missed, 1, load);
    }
    wrong = ended ? "interrupted" : is_known ? wrong : "the estimate is lost";
    if (tick)
        ramp_down(tick);
    return wrong;
}

int main(int count, char **arguments)
{
    struct sockaddr_in there = {0};
    there.sin_family = AF_INET;
    line = socket(AF_INET, SOCK_DGRAM, 0);
    if (count < 4 || inet_pton(AF_INET, arguments[1], &there.sin_addr) != 1 || line < 0)
        return fprintf(stderr, "usage: controller ADDRESS PORT lockstep|realtime [KEY_FILE] < REFERENCE\n"), 2;
    there.sin_port = htons((uint16_t)strtoul(arguments[2], NULL, 10));
    lockstep = strcmp(arguments[3], "lockstep") == 0;
    if (count > 4 && (key_size = read_file(arguments[4], pre_shared, MAX_KEY)) < 16)
        return fprintf(stderr, "controller: no key of 16 bytes in %s\n", arguments[4]), 2;
    if (!open_law() || !open_estimator() || connect(line, (const struct sockaddr *)&there, sizeof there) < 0)
        return fprintf(stderr, "controller: no robot, or no way there\n"), 2;
    struct sigaction action = {0};
    action.sa_handler = end;
    sigaction(SIGINT, &action, NULL), sigaction(SIGTERM, &action, NULL);
    if (!greet())
        return 1;
    const char *wrong = !estimate(state, 1, 0, load) ? "the first pose is not found"
                        : !is_near()                 ? "it is too far from its start"
                                                     : drive();
    stop();
    if (wrong)
        fprintf(stderr, "controller: %s\n", wrong);
    return wrong != NULL;
}
