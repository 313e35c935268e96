/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers as the protocol writes them: little endian, floats as IEEE 754 single precision.
 *
 * Byte by byte, so that neither the byte order nor the alignment rules of the processor matter. Each `put` returns where
 * the next number goes. */
#ifndef OMNIPUCK_BYTES_H
#define OMNIPUCK_BYTES_H

#include <stdbool.h>
#include <stdint.h>

/* A union instead of memcpy: C99 allows it, and the firmware then needs no string.h. */
union omnipuck_float_bits {
    float value;
    uint32_t bits;
};

static inline uint16_t omnipuck_get_u16(const uint8_t *from)
{
    return (uint16_t)(from[0] | ((uint32_t)from[1] << 8));
}

static inline uint32_t omnipuck_get_u32(const uint8_t *from)
{
    return (uint32_t)from[0] | ((uint32_t)from[1] << 8) | ((uint32_t)from[2] << 16) | ((uint32_t)from[3] << 24);
}

static inline float omnipuck_get_f32(const uint8_t *from)
{
    union omnipuck_float_bits number;
    number.bits = omnipuck_get_u32(from);
    return number.value;
}

static inline uint8_t *omnipuck_put_u8(uint8_t *to, uint8_t value)
{
    to[0] = value;
    return to + 1;
}

static inline uint8_t *omnipuck_put_u16(uint8_t *to, uint16_t value)
{
    to[0] = (uint8_t)(value & 0xFFU);
    to[1] = (uint8_t)(value >> 8);
    return to + 2;
}

static inline uint8_t *omnipuck_put_u32(uint8_t *to, uint32_t value)
{
    return omnipuck_put_u16(omnipuck_put_u16(to, (uint16_t)(value & 0xFFFFU)), (uint16_t)(value >> 16));
}

static inline uint8_t *omnipuck_put_f32(uint8_t *to, float value)
{
    union omnipuck_float_bits number;
    number.value = value;
    return omnipuck_put_u32(to, number.bits);
}

/* By the bits, because a compiler with -ffast-math may assume that every float is finite. */
static inline bool omnipuck_is_finite(float value)
{
    union omnipuck_float_bits number;
    number.value = value;
    return (number.bits & 0x7F800000U) != 0x7F800000U;
}

#endif
