/* A controller for docs/reference/hardware_protocol.md: the counterpart of device.c, without Python.
 *
 * A computed-torque law receives the state by UDP and sends the forces. make_controller.py writes robot.h
 * and the reference of an experiment:
 *
 *     python make_controller.py ../planar_2r build
 *     cc -std=c99 -O2 -ffp-contract=off -DCARDSFLOW_INSIDE -Ibuild controller.c \
 *         $(find ../../sim_dart/csrc ../../controllers/csrc -name "*.c" \
 *             ! -path "*freestanding*" ! -path "*tangent*") -o build/controller -lm
 *     build/controller 127.0.0.1 5005 realtime < build/reference.f64 > run.csv    (with a running device)
 *
 * For a processor with a single-precision floating point unit, write robot.h with
 * `make_controller.py --single` and compile the law in single precision:
 *
 *     gcc -DCARDSFLOW_FLOAT -fsingle-precision-constant ...
 *
 * If the experiment has an [estimator], q and qd are estimated from lengths and tensions:
 * robot_estimator.h. The program does not allocate memory. On a microcontroller, replace
 * platform.h, the socket and the source of random numbers. */
#define _POSIX_C_SOURCE 200809L

#include "robot_estimator.h"

#include <arpa/inet.h>
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
#include "platform.h"

static const uint64_t REPEAT = 20000000;  /* [ns] */
static const double PATIENCE = 0.6, RAMP_DOWN = 0.5, NEAR = 0.1; /* fraction of a step, [s], [rad] or [m] */
enum { HELLOS = 40, STOPS = 10 };
#ifndef MAX_MISSED
#define MAX_MISSED 10 /* consecutive answers, in real time */
#endif

/* ---- The link: send one frame, receive one */
static int line, lockstep;
static uint32_t run, seq;
static uint64_t origin; /* start of the run */
static double state[STATES], forces[MUSCLES]; /* latest state; last commands */
static real load[COORDINATES];
static struct frame f;
static struct packed sent;
static volatile sig_atomic_t ended;

static int most_missed(void) { return lockstep ? 0 : MAX_MISSED; }

static void end(int number) { ended = number; }

static void send_frame(unsigned kind, double t, const double *values, unsigned count)
{
    f.kind = kind, f.flags = lockstep ? LOCKSTEP : 0, f.count = count;
    f.run = run, f.seq = seq, f.t = t, f.sent = clock_ns(), f.echo = 0;
    if (count)
        memcpy(f.values, values, count * sizeof *values);
    pack(&f, &sent);
    (void)send(line, sent.bytes, sent.size, 0);
}

/* Return whether a frame of this run and one of two kinds arrives until then; it is in `f`. */
static int receive_frame(unsigned kind, unsigned other, uint64_t until)
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

static int is_half(double half) { return half >= 0 && half < 4294967296.0 && half == floor(half); }

/* Start the run that the device has accepted, in a HELLO_ACK. Return whether the frame is valid. */
static int begin(void)
{
    if (f.count != ACK_VALUES + STATES || !is_half(f.values[7]) || !is_half(f.values[8]))
        return 0;
    set_run_key(run, (uint64_t)f.values[7] << 32 | (uint64_t)f.values[8]);
    memcpy(state, f.values + ACK_VALUES, sizeof state);
    origin = clock_ns();
    return 1;
}

/* Return whether the device accepts a run; `state` is then the state of the device. */
static int connect_device(void)
{
    const double request[HELLO_VALUES] = {SIGNATURE_HIGH, SIGNATURE_LOW, STEP, 1, 0, COMMANDS, STATES};
    if (read_file("/dev/urandom", &run, sizeof run) != sizeof run || !run)
        run = (uint32_t)clock_ns() | 1;
    for (int k = 0; k < HELLOS && !ended; k++) {
        send_frame(HELLO, 0, request, HELLO_VALUES);
        if (!receive_frame(HELLO_ACK, ERROR, clock_ns() + SECOND / 20))
            continue;
        if (f.kind == HELLO_ACK && begin()) {
            if (key_size) /* confirms the run: a hello may be a copy */
                send_frame(PING, 0, request, HELLO_VALUES);
            if (!key_size || receive_frame(PONG, PONG, clock_ns() + SECOND / 20))
                return 1;
            continue;
        }
        if (f.kind != ERROR || f.count != 1 || f.values[0] != BUSY)
            return fprintf(stderr, "controller: the device rejects the run; see the codes of the protocol\n"), 0;
    }
    return fprintf(stderr, "controller: no answer, or the device is in use\n"), 0;
}

/* Return whether a new state arrives: in lockstep lost frames are sent again, in real time they are missed. */
static int exchange(double t)
{
    const uint64_t begin = clock_ns(), patience = (uint64_t)(PATIENCE * STEP * (double)SECOND);
    const uint64_t until = begin + (lockstep ? SECOND : patience);
    seq++;
    send_frame(SETPOINT, t, forces, COMMANDS);
    while (!ended && clock_ns() < until) {
        const uint64_t again = clock_ns() + REPEAT;
        if (!receive_frame(STATE, STATE, again < until ? again : until)) {
            (void)(lockstep && send(line, sent.bytes, sent.size, 0));
        } else if (f.seq == seq && f.count == STATES) {
            memcpy(state, f.values, sizeof state);
            return 1;
        }
    }
    return 0;
}

/* In real time, wait for time t of the run. A delay of more than a step shifts the run, without a burst. */
static void wait_until(double t)
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
    ended = 0; /* a second Ctrl-C ends the ramp */
    for (long left = steps, missed = 0; left-- && !ended && missed <= most_missed(); tick++) {
        for (int i = 0; i < MUSCLES; i++)
            forces[i] = F_MIN[i] + (double)left / (double)steps * (top[i] - F_MIN[i]);
        wait_until((double)tick * STEP);
        missed = exchange((double)tick * STEP) ? 0 : missed + 1;
    }
}

/* Tell the device to stop, until it confirms. */
static void stop(void)
{
    for (int k = 0; k < STOPS; k++) {
        send_frame(STOP, 0, NULL, 0);
        if (receive_frame(STOPPED, STOPPED, clock_ns() + REPEAT))
            return;
    }
}

/* ---- The run */
static void print_row(double t)
{
    printf("%.17g", t);
    for (int j = 0; j < COORDINATES; j++)
        printf(",%.17g", state[j]);
    for (int i = 0; i < MUSCLES; i++)
        printf(",%.17g", forces[i]);
    putchar('\n');
}

/* Read position, velocity and acceleration for the next tick. Return 0 at the end. */
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

/* Run. Return the error, or NULL. If the device still follows, the forces decrease slowly at the end. */
static const char *drive(void)
{
    double reference[3 * ROWS], found[MUSCLES];
    long tick = 0;
    const char *wrong = NULL;
    int is_known = 1;
    for (int missed = 0; !ended && !wrong && is_known && next_reference(reference); tick++) {
        const double t = (double)tick * STEP;
        wait_until(t);
        if (tick_law(STEP, state, reference, load, found) >= COMPUTED_TORQUE_FAILED || !are_finite(found)) {
            wrong = "no forces found";
            break;
        }
        memcpy(forces, found, sizeof forces);
        print_row(t);
        missed = exchange(t) ? 0 : missed + 1;
        if (missed > most_missed())
            return "the device does not answer";
        if (!missed && f.flags & SAFE)
            return "the device is in its safe state";
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
        return fprintf(stderr, "controller: invalid robot or address\n"), 2;
    struct sigaction action = {0};
    action.sa_handler = end;
    sigaction(SIGINT, &action, NULL), sigaction(SIGTERM, &action, NULL);
    if (!connect_device())
        return 1;
    const char *wrong = !estimate(state, 1, 0, load) ? "the first pose was not found"
                        : !is_near()                 ? "the robot is too far from its start"
                                                     : drive();
    stop();
    if (wrong)
        fprintf(stderr, "controller: %s\n", wrong);
    return wrong != NULL;
}
