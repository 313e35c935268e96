/* SPDX-License-Identifier: Apache-2.0 */
/* CRC-32 of IEEE 802.3, the one of zlib: of "123456789" it is CBF43926. */
#ifndef OMNIPUCK_CRC32_H
#define OMNIPUCK_CRC32_H

#include <stddef.h>
#include <stdint.h>

uint32_t omnipuck_crc32(const uint8_t *bytes, size_t length);

#endif
