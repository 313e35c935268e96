/* SPDX-License-Identifier: Apache-2.0 */
#include "transmitter.h"

void omnipuck_transmitter_start(struct omnipuck_transmitter *transmitter)
{
    transmitter->length = 0;
    transmitter->sent = 0;
    transmitter->sequence = 0;
}

bool omnipuck_transmitter_flush(struct omnipuck_transmitter *transmitter, const struct omnipuck_hardware *hardware)
{
    const size_t waiting = transmitter->length - transmitter->sent;
    if (waiting == 0) {
        return true;
    }
    const size_t taken = hardware->write(hardware->context, transmitter->bytes + transmitter->sent, waiting);
    /* Not trusted: a board that says more than it was given would send this beyond its buffer. */
    transmitter->sent += taken < waiting ? taken : waiting;
    return transmitter->sent == transmitter->length;
}

uint8_t *omnipuck_transmitter_payload(struct omnipuck_transmitter *transmitter)
{
    return transmitter->bytes + OMNIPUCK_PAYLOAD_AT;
}

bool omnipuck_transmitter_send(struct omnipuck_transmitter *transmitter, const struct omnipuck_hardware *hardware,
                               uint8_t type, size_t payload_length)
{
    transmitter->length = omnipuck_frame_close(transmitter->bytes, type, transmitter->sequence, payload_length);
    transmitter->sent = 0;
    omnipuck_transmitter_flush(transmitter, hardware);
    if (transmitter->sent == 0) {
        transmitter->length = 0;
        return false;
    }
    ++transmitter->sequence;
    return true;
}
