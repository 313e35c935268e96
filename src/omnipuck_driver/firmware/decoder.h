/* SPDX-License-Identifier: Apache-2.0 */
/* Bytes from the port to messages, one byte at a time. Needs nothing else of the firmware, so it can be fuzzed alone. */
#ifndef OMNIPUCK_DECODER_H
#define OMNIPUCK_DECODER_H

#include "frame.h"
#include "messages.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum omnipuck_heard {
    OMNIPUCK_HEARD_NOTHING,      /* no frame ends with this byte */
    OMNIPUCK_HEARD_MESSAGE,      /* one does, and the message is filled in */
    OMNIPUCK_HEARD_DROPPED,      /* one does, and is counted in drops */
    OMNIPUCK_HEARD_OTHER_VERSION /* the same, but it is undamaged and of another version */
};

struct omnipuck_decoder {
    uint8_t bytes[OMNIPUCK_ENCODED_MAX]; /* since the last 00 */
    size_t length;
    bool too_long;
    bool numbered;     /* a message was received */
    uint16_t sequence; /* of the newest message */
    uint16_t accepted; /* modulo 2^16 */
    uint16_t dropped;  /* modulo 2^16, the sum of drops */
    uint16_t drops[OMNIPUCK_DROP_REASONS];
};

void omnipuck_decoder_start(struct omnipuck_decoder *decoder);

/* message is only good if the result is OMNIPUCK_HEARD_MESSAGE. */
enum omnipuck_heard omnipuck_decoder_feed(struct omnipuck_decoder *decoder, uint8_t byte, struct omnipuck_message *message);

#endif
