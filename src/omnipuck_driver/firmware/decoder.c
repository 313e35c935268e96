/* SPDX-License-Identifier: Apache-2.0 */
#include "decoder.h"

void omnipuck_decoder_start(struct omnipuck_decoder *decoder)
{
    decoder->length = 0;
    decoder->too_long = false;
    decoder->numbered = false;
    decoder->sequence = 0;
    decoder->accepted = 0;
    decoder->dropped = 0;
    for (int reason = 0; reason < OMNIPUCK_DROP_REASONS; ++reason) {
        decoder->drops[reason] = 0;
    }
}

/* A host that starts again does not know where its numbers were, so a Hello is never a repetition. */
static bool is_repetition(const struct omnipuck_decoder *decoder, enum omnipuck_type type, uint16_t sequence)
{
    const uint16_t ahead = (uint16_t)(sequence - decoder->sequence);
    return type != OMNIPUCK_HELLO && decoder->numbered && (ahead == 0 || ahead >= 0x8000U);
}

static enum omnipuck_drop frame_ended(struct omnipuck_decoder *decoder, struct omnipuck_message *message)
{
    if (decoder->too_long) {
        return OMNIPUCK_DROP_TOO_LONG;
    }
    struct omnipuck_frame frame;
    enum omnipuck_drop drop = omnipuck_frame_open(decoder->bytes, decoder->length, &frame);
    if (drop == OMNIPUCK_DROP_NONE) {
        drop = omnipuck_message_read(&frame, message);
    }
    if (drop == OMNIPUCK_DROP_NONE && is_repetition(decoder, message->type, frame.sequence)) {
        drop = OMNIPUCK_DROP_REPETITION;
    }
    if (drop == OMNIPUCK_DROP_NONE) {
        decoder->numbered = true;
        decoder->sequence = frame.sequence;
    }
    return drop;
}

enum omnipuck_heard omnipuck_decoder_feed(struct omnipuck_decoder *decoder, uint8_t byte, struct omnipuck_message *message)
{
    if (byte != 0) {
        if (decoder->length < OMNIPUCK_ENCODED_MAX) {
            decoder->bytes[decoder->length++] = byte;
        } else {
            decoder->too_long = true;
        }
        return OMNIPUCK_HEARD_NOTHING;
    }
    if (decoder->length == 0) {
        return OMNIPUCK_HEARD_NOTHING;
    }
    const enum omnipuck_drop drop = frame_ended(decoder, message);
    decoder->length = 0;
    decoder->too_long = false;
    if (drop == OMNIPUCK_DROP_NONE) {
        ++decoder->accepted;
        return OMNIPUCK_HEARD_MESSAGE;
    }
    ++decoder->dropped;
    ++decoder->drops[drop];
    return drop == OMNIPUCK_DROP_VERSION ? OMNIPUCK_HEARD_OTHER_VERSION : OMNIPUCK_HEARD_DROPPED;
}
