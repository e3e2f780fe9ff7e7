/* libFuzzer inputs as datagrams for the device and the controller in C, unsigned and signed.

   An input is a byte that enables the key, and frames, each preceded by its length in two bytes. Checksum
   and signature are corrected, since no fuzzer would find them. */
#define main program
#include FUZZ_PROGRAM
#undef main

static void seal(uint8_t *data, size_t *size)
{
    const unsigned flags = (unsigned)get(data + 6, 2) & ~1u;
    const size_t end = HEADER + 8 * (size_t)get(data + 40, 2);
    put(data, 4, MAGIC), data[4] = VERSION, put(data + 6, 2, flags | (key_size ? SIGNED : 0));
    if (end > *size) return;
    *size = end;
    put(data + 44, 4, checksum(data, end));
    if (!key_size) return;
    sign(data, end, data[5], data + end);
    *size += SHA256_BYTES;
}

#if defined(FUZZ_DEVICE)
static void start(void)
{
    state = IDLE, run = 0, last_seq = 0, lockstep = 0, device_time = 0, answer.size = 0;
    signature = 0x0000000100000002u;
    robot_reset();
}

static void take(const uint8_t *data, size_t size)
{
    static uint64_t now = 1;
    struct sockaddr_in from = {0};
    from.sin_port = (uint16_t)(size % 2);
    if (size >= HEADER && data[5] != HELLO && state != IDLE) put((uint8_t *)data + 8, 4, run);
    receive(data, size, &from, now += 1000000);
    for (int i = 0; i < COMMANDS; i++)
        if (!(command[i] >= 0 && command[i] <= 2 * F_MAX)) abort(); /* no actuator reaches this force */
    if (state != IDLE) robot_advance(STEP);
}
#else
static void start(void) { run = 0; }

static void take(const uint8_t *data, size_t size)
{
    if (!unpack(data, size, &f)) return;
    run = f.run;
    if (f.kind == HELLO_ACK) begin();
}
#endif

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t frame[8192];
    if (size < 1) return 0;
    key_size = data[0] % 2 ? 16 : 0;
    start();
    for (size_t at = 1; at + 2 <= size;) {
        size_t length = (size_t)data[at] | (size_t)data[at + 1] << 8, begin = at + 2;
        if (length > size - begin) length = size - begin;
        if (length > 4096) length = 4096;
        memset(frame, 0, sizeof frame);
        memcpy(frame, data + begin, length);
        size_t taken = length;
        if (length >= HEADER) seal(frame, &taken);
        uint8_t *exact = malloc(taken + !taken);
        if (!exact) return 0;
        memcpy(exact, frame, taken);
        take(exact, taken);
        free(exact);
        at = begin + length;
    }
    return 0;
}
