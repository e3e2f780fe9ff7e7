/* The frame of docs/reference/hardware_protocol.md in portable C99: pack, unpack, checksum, authentication.
 *
 * Define MAX_VALUES before including this file: frames with more values are rejected. */
#ifndef FRAME_H
#define FRAME_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "hmac_sha256.h"

/* Kinds, flags, and reasons for rejecting a hello. */
enum { HELLO = 1, HELLO_ACK, SETPOINT, STATE, STOP, STOPPED, ERROR, PING, PONG };
enum { SIGNED = 1, LOCKSTEP = 2, SAFE = 4, CLAMPED = 16 };
enum { BUSY = 1, PORTS, WRONG_SCALE, WRONG_STEP, SHORT_WATCHDOG, WRONG_MODE, FAULT };
enum { HEADER = 48, MAGIC = 0x57484643, VERSION = 1 };

struct frame {
    unsigned kind, flags, count;
    uint32_t run, seq;
    double t, values[MAX_VALUES];
    uint64_t sent, echo;
};

struct packed {
    uint8_t bytes[HEADER + 8 * MAX_VALUES + SHA256_BYTES];
    size_t size;
};

enum { MAX_KEY = 256 };
static uint8_t pre_shared[MAX_KEY + 1], run_key[SHA256_BYTES];
static size_t key_size; /* 0: frames are not signed */

static uint64_t get(const uint8_t *at, int bytes)
{
    uint64_t value = 0;
    while (bytes--)
        value = value << 8 | at[bytes];
    return value;
}

static void put(uint8_t *at, int bytes, uint64_t value)
{
    for (int i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> (8 * i));
}

static double get_double(const uint8_t *at)
{
    const uint64_t bits = get(at, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void put_double(uint8_t *at, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put(at, 8, bits);
}

static uint32_t checksum(const uint8_t *data, size_t size) /* CRC-32 as in Ethernet and zip */
{
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        crc ^= i >= 44 && i < 48 ? 0 : data[i]; /* the checksum itself is replaced by zeros */
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static void set_run_key(uint32_t run, uint64_t nonce)
{
    uint8_t both[12];
    put(both, 4, run), put(both + 4, 8, nonce);
    hmac_sha256(pre_shared, key_size, both, sizeof both, run_key);
}

static void sign(const uint8_t *data, size_t size, unsigned kind, uint8_t *mac)
{
    if (kind == HELLO || kind == HELLO_ACK || kind == ERROR)
        hmac_sha256(pre_shared, key_size, data, size, mac);
    else
        hmac_sha256(run_key, sizeof run_key, data, size, mac);
}

/* Return whether the bytes are one whole frame: undamaged, with finite numbers, and signed if a key is set. */
static int unpack(const uint8_t *data, size_t size, struct frame *f)
{
    if (size < HEADER || get(data, 4) != MAGIC || data[4] != VERSION)
        return 0;
    f->kind = data[5], f->flags = (unsigned)get(data + 6, 2);
    f->count = (unsigned)get(data + 40, 2);
    f->run = (uint32_t)get(data + 8, 4), f->seq = (uint32_t)get(data + 12, 4);
    f->t = get_double(data + 16), f->sent = get(data + 24, 8);
    const size_t end = HEADER + 8 * (size_t)f->count;
    uint8_t mac[SHA256_BYTES];
    if (f->count > MAX_VALUES || size != end + (key_size ? SHA256_BYTES : 0) || !isfinite(f->t) ||
        !(f->flags & SIGNED) != !key_size || checksum(data, end) != get(data + 44, 4))
        return 0;
    if (key_size) {
        sign(data, end, f->kind, mac);
        if (!same_bytes(mac, data + end, sizeof mac))
            return 0;
    }
    for (unsigned i = 0; i < f->count; i++)
        if (f->values[i] = get_double(data + HEADER + 8 * i), !isfinite(f->values[i]))
            return 0;
    return 1;
}

static void pack(const struct frame *f, struct packed *to)
{
    put(to->bytes, 4, MAGIC);
    to->bytes[4] = VERSION, to->bytes[5] = (uint8_t)f->kind;
    put(to->bytes + 6, 2, f->flags | (key_size ? SIGNED : 0));
    put(to->bytes + 8, 4, f->run), put(to->bytes + 12, 4, f->seq);
    put_double(to->bytes + 16, f->t);
    put(to->bytes + 24, 8, f->sent), put(to->bytes + 32, 8, f->echo);
    put(to->bytes + 40, 4, f->count);
    for (unsigned i = 0; i < f->count; i++)
        put_double(to->bytes + HEADER + 8 * i, f->values[i]);
    to->size = HEADER + 8 * (size_t)f->count;
    put(to->bytes + 44, 4, checksum(to->bytes, to->size));
    if (key_size) {
        sign(to->bytes, to->size, f->kind, to->bytes + to->size);
        to->size += SHA256_BYTES;
    }
}

#endif
