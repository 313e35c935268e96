/* SPDX-License-Identifier: Apache-2.0 */
#include "frame.h"

#include "bytes.h"
#include "cobs.h"
#include "crc32.h"

enum omnipuck_drop omnipuck_frame_open(uint8_t *encoded, size_t length, struct omnipuck_frame *frame)
{
    if (!omnipuck_cobs_decode(encoded, &length)) {
        return OMNIPUCK_DROP_COBS;
    }
    if (length < OMNIPUCK_HEADER_SIZE + OMNIPUCK_CRC_SIZE) {
        return OMNIPUCK_DROP_TOO_SHORT;
    }
    const size_t checked = length - OMNIPUCK_CRC_SIZE;
    if (omnipuck_crc32(encoded, checked) != omnipuck_get_u32(encoded + checked)) {
        return OMNIPUCK_DROP_CRC;
    }
    if (encoded[0] != OMNIPUCK_VERSION) {
        return OMNIPUCK_DROP_VERSION;
    }
    frame->type = encoded[1];
    frame->sequence = omnipuck_get_u16(encoded + 2);
    frame->payload = encoded + OMNIPUCK_HEADER_SIZE;
    frame->payload_length = checked - OMNIPUCK_HEADER_SIZE;
    return OMNIPUCK_DROP_NONE;
}

size_t omnipuck_frame_close(uint8_t *bytes, uint8_t type, uint16_t sequence, size_t payload_length)
{
    uint8_t *body = bytes + 2;
    const size_t checked = OMNIPUCK_HEADER_SIZE + payload_length;
    omnipuck_put_u16(omnipuck_put_u8(omnipuck_put_u8(body, OMNIPUCK_VERSION), type), sequence);
    omnipuck_put_u32(body + checked, omnipuck_crc32(body, checked));

    const size_t body_length = checked + OMNIPUCK_CRC_SIZE;
    omnipuck_cobs_encode(bytes + 1, body_length);
    bytes[0] = 0;
    body[body_length] = 0;
    return body_length + 3;
}
