/* SPDX-License-Identifier: Apache-2.0 */
/* Frames to the host through a port that may take only a part of what it is given.
 *
 * There is room for one frame. While a part of it waits, no other is begun; a frame of which the port takes nothing at all
 * is forgotten, so what is sent is never older than the port's own buffer. Half a frame is never left without its end. */
#ifndef OMNIPUCK_TRANSMITTER_H
#define OMNIPUCK_TRANSMITTER_H

#include "frame.h"
#include "hardware.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct omnipuck_transmitter {
    uint8_t bytes[OMNIPUCK_FRAME_MAX];
    size_t length; /* of the frame in bytes, 0: none waits */
    size_t sent;
    uint16_t sequence; /* of the next frame */
};

void omnipuck_transmitter_start(struct omnipuck_transmitter *transmitter);

/* Hands over what waits; true if nothing does any more. */
bool omnipuck_transmitter_flush(struct omnipuck_transmitter *transmitter, const struct omnipuck_hardware *hardware);

/* Where to write the next payload; only while nothing waits. */
uint8_t *omnipuck_transmitter_payload(struct omnipuck_transmitter *transmitter);

/* Sends the payload written there. False if the port took nothing: then the frame is forgotten, and its number not used. */
bool omnipuck_transmitter_send(struct omnipuck_transmitter *transmitter, const struct omnipuck_hardware *hardware,
                               uint8_t type, size_t payload_length);

#endif
