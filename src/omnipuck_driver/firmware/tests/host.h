/* SPDX-License-Identifier: Apache-2.0 */
/* The host's side of the protocol, for tests: written apart from the firmware's, and sharing none of its code, so that a
 * mistake in one does not agree with itself. */
#ifndef OMNIPUCK_TEST_HOST_H
#define OMNIPUCK_TEST_HOST_H

#include "messages.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { HOST_FRAME_MAX = 300 };

/* A frame as it was read, whatever its version and type. */
struct host_frame {
    uint8_t body[HOST_FRAME_MAX];
    size_t length; /* of the body */
    uint8_t version;
    uint8_t type;
    uint16_t sequence;
    const uint8_t *payload; /* in body */
    size_t payload_length;
};

uint32_t host_crc(const uint8_t *bytes, size_t length);

/* Both return the length of the result, which must not lie over the bytes. */
size_t host_stuff(const uint8_t *bytes, size_t length, uint8_t *stuffed);
size_t host_write_frame(uint8_t *frame, uint8_t version, uint8_t type, uint16_t sequence, const uint8_t *payload,
                        size_t length);

/* False if the bytes are no COBS. */
bool host_unstuff(const uint8_t *stuffed, size_t length, uint8_t *bytes, size_t *unstuffed);

/* Of what stands between two 00. False if COBS or crc do not fit, or it is too short or too long. */
bool host_read_frame(const uint8_t *stuffed, size_t length, struct host_frame *frame);

size_t host_write_hello(uint8_t *payload, const struct omnipuck_hello *hello);
size_t host_write_command(uint8_t *payload, const struct omnipuck_command *command);

/* False if the frame is none, or has not the right length. */
bool host_read_hello(const struct host_frame *frame, struct omnipuck_hello *hello);
bool host_read_command(const struct host_frame *frame, struct omnipuck_command *command);
bool host_read_announce(const struct host_frame *frame, struct omnipuck_announce *announce, char *firmware);
bool host_read_telemetry(const struct host_frame *frame, struct omnipuck_telemetry *telemetry);

#endif
