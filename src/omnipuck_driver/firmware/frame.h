/* SPDX-License-Identifier: Apache-2.0 */
/* A frame: 00 | COBS( version u8 | type u8 | sequence u16 | payload | crc u32 ) | 00. The same in every version of the
 * protocol, whatever its payloads are. */
#ifndef OMNIPUCK_FRAME_H
#define OMNIPUCK_FRAME_H

#include <stddef.h>
#include <stdint.h>

enum {
    OMNIPUCK_VERSION = 2,
    OMNIPUCK_HEADER_SIZE = 4,
    OMNIPUCK_CRC_SIZE = 4,
    OMNIPUCK_BODY_MAX = 128,
    OMNIPUCK_PAYLOAD_MAX = OMNIPUCK_BODY_MAX - OMNIPUCK_HEADER_SIZE - OMNIPUCK_CRC_SIZE,
    OMNIPUCK_ENCODED_MAX = OMNIPUCK_BODY_MAX + 1,
    OMNIPUCK_FRAME_MAX = OMNIPUCK_ENCODED_MAX + 2,
    /* Where the payload stands in a frame that is being written: after 00, the first byte of COBS and the header. */
    OMNIPUCK_PAYLOAD_AT = 2 + OMNIPUCK_HEADER_SIZE
};

/* Why a frame is dropped. */
enum omnipuck_drop {
    OMNIPUCK_DROP_NONE,
    OMNIPUCK_DROP_TOO_LONG,
    OMNIPUCK_DROP_COBS,
    OMNIPUCK_DROP_TOO_SHORT,
    OMNIPUCK_DROP_CRC,
    OMNIPUCK_DROP_VERSION,
    OMNIPUCK_DROP_TYPE,
    OMNIPUCK_DROP_LENGTH,
    OMNIPUCK_DROP_CONTENT, /* a float that is not finite, a cap not above 0, too many wheels */
    OMNIPUCK_DROP_REPETITION,
    OMNIPUCK_DROP_REASONS
};

struct omnipuck_frame {
    uint8_t type;
    uint16_t sequence;
    const uint8_t *payload; /* in the bytes it was opened in */
    size_t payload_length;
};

/* Opens, in place, what came between two 00. OMNIPUCK_DROP_NONE, or why it is no frame of this version; the crc is looked
 * at before the version, so OMNIPUCK_DROP_VERSION is given for undamaged frames only. */
enum omnipuck_drop omnipuck_frame_open(uint8_t *encoded, size_t length, struct omnipuck_frame *frame);

/* Puts header, crc, COBS and both 00 around the payload that stands at bytes[OMNIPUCK_PAYLOAD_AT]. bytes has room for
 * OMNIPUCK_FRAME_MAX. Returns the length of the whole. */
size_t omnipuck_frame_close(uint8_t *bytes, uint8_t type, uint16_t sequence, size_t payload_length);

#endif
