/* SPDX-License-Identifier: Apache-2.0 */
#include "cobs.h"

void omnipuck_cobs_encode(uint8_t *bytes, size_t length)
{
    uint8_t distance = 1;
    for (size_t at = length; at > 0; --at) {
        if (bytes[at] == 0) {
            bytes[at] = distance;
            distance = 0;
        }
        ++distance;
    }
    bytes[0] = distance;
}

bool omnipuck_cobs_decode(uint8_t *bytes, size_t *length)
{
    size_t from = 0;
    size_t to = 0;
    while (from < *length) {
        size_t code = bytes[from];
        if (code == 0 || code > *length - from) {
            return false;
        }
        for (size_t i = 1; i < code; ++i) {
            bytes[to++] = bytes[from + i];
        }
        from += code;
        if (code != 0xFF && from < *length) {
            bytes[to++] = 0;
        }
    }
    *length = to;
    return true;
}
