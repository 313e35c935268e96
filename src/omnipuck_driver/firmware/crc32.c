/* SPDX-License-Identifier: Apache-2.0 */
#include "crc32.h"

/* Bit by bit: a table would be faster, but takes 1 KiB of flash, and at 115200 bit/s there are at most 12 bytes in each
 * millisecond and direction. */
uint32_t omnipuck_crc32(const uint8_t *bytes, size_t length)
{
    const uint32_t polynomial = 0xEDB88320U;
    uint32_t crc = 0xFFFFFFFFU;
    for (size_t i = 0; i < length; ++i) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc >> 1) ^ ((crc & 1U) != 0 ? polynomial : 0U);
        }
    }
    return ~crc;
}
