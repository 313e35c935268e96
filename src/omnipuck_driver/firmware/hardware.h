/* SPDX-License-Identifier: Apache-2.0 */
/* What the firmware asks of a board. `context` is handed to every function, for the board's own use.
 *
 * Every function returns at once: none waits for a port, a converter or a motor. All are called from omnipuck_start and
 * omnipuck_step only, and need not be safe against each other. What an interrupt writes (clock, bytes that came, a press, an
 * impact) must be read, and taken, in one piece: on a processor that needs several steps for it, with interrupts off. */
#ifndef OMNIPUCK_HARDWARE_H
#define OMNIPUCK_HARDWARE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct omnipuck_hardware {
    void *context;

    /* [ms] since any moment, never set, modulo 2^32: it must run through all 32 bits before it is 0 again, and never go back,
     * not by 1 ms: that would be 2^32 ms ahead. Read in one piece where an interrupt counts it. */
    uint32_t (*clock)(void *context);

    /* Takes up to capacity bytes that came from the host; returns how many. */
    size_t (*read)(void *context, uint8_t *bytes, size_t capacity);

    /* Hands over up to length bytes to the host; returns how many were taken, be it none. */
    size_t (*write)(void *context, const uint8_t *bytes, size_t length);

    /* [rad/s], positive counter-clockwise around the robot. The caps and the ramp are in them already. */
    void (*set_wheel_speeds)(void *context, const float *speeds, size_t wheels);

    /* [rad/s], the same signs. */
    void (*measure_wheel_speeds)(void *context, float *speeds, size_t wheels);

    /* [mV] */
    uint16_t (*battery)(void *context);

    /* [0.1 deg C], or OMNIPUCK_TEMPERATURE_NOT_MEASURED. May be NULL on a board that does not measure it. */
    int16_t (*temperature)(void *context);

    /* Pressed now, or since the last call: a short press must not get lost. Where an interrupt notes it, look and forget in
     * one piece: a press between the two would be forgotten. */
    bool (*emergency_button_pressed)(void *context);

    /* A motor has a fault now; true as long as it lasts. */
    bool (*motor_fault)(void *context);

    /* True as long as it lasts; where it begins and ends is the board's to say. */
    bool (*too_hot)(void *context);

    /* Takes the oldest impact not taken yet: its change of velocity [m/s] in the body frame at that moment. False if there
     * is none. May be NULL on a board that does not sense them. */
    bool (*take_impact)(void *context, float *x, float *y);
};

#endif
