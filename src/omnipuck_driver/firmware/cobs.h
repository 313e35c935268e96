/* SPDX-License-Identifier: Apache-2.0 */
/* Consistent overhead byte stuffing (Cheshire and Baker 1999): takes the zeros out of a body, so that 00 can stand between
 * frames. Both ways work in place. */
#ifndef OMNIPUCK_COBS_H
#define OMNIPUCK_COBS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Encodes the body in bytes[1] to bytes[length]; the result fills bytes[0] to bytes[length]. length is at most 253: a body
 * that short (the protocol's have at most 128 bytes) grows by one byte exactly, which is why it can be done in place. */
void omnipuck_cobs_encode(uint8_t *bytes, size_t length);

/* Decodes bytes[0] to bytes[*length - 1] to the front of bytes, and says in *length how many bytes it became. False if the
 * bytes are no COBS. */
bool omnipuck_cobs_decode(uint8_t *bytes, size_t *length);

#endif
