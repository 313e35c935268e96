/* SPDX-License-Identifier: Apache-2.0 */
/* The payloads. What the device hears is read, what it says is written. */
#ifndef OMNIPUCK_MESSAGES_H
#define OMNIPUCK_MESSAGES_H

#include "frame.h"

#include <stddef.h>
#include <stdint.h>

enum {
    OMNIPUCK_WHEELS_MAX = 8,
    OMNIPUCK_FIRMWARE_NAME_SIZE = 12
};

enum omnipuck_type {
    OMNIPUCK_HELLO = 0x01,
    OMNIPUCK_COMMAND = 0x02,
    OMNIPUCK_ANNOUNCE = 0x81,
    OMNIPUCK_TELEMETRY = 0x82
};

enum omnipuck_flag {
    OMNIPUCK_FLAG_EMERGENCY_STOP = 1 << 0,
    OMNIPUCK_FLAG_HOLD = 1 << 1
};

enum omnipuck_capability {
    OMNIPUCK_SENSES_IMPACTS = 1 << 0,
    OMNIPUCK_MEASURES_TEMPERATURE = 1 << 1
};

enum omnipuck_status {
    OMNIPUCK_STATUS_ARMED = 1 << 0,
    OMNIPUCK_STATUS_BUTTON_PRESSED = 1 << 1,
    OMNIPUCK_STATUS_BATTERY_LOW = 1 << 2,
    OMNIPUCK_STATUS_OUTLIVED = 1 << 3,
    OMNIPUCK_STATUS_HELD_UP = 1 << 4,
    OMNIPUCK_STATUS_MOTOR_FAULT = 1 << 5,
    OMNIPUCK_STATUS_TOO_HOT = 1 << 6,
    OMNIPUCK_STATUS_LATCHED = 1 << 7
};

enum {
    OMNIPUCK_TEMPERATURE_NOT_MEASURED = 0x7FFF
};

/* Not in an enum: an int of 16 bits cannot hold it. */
#define OMNIPUCK_NO_AGE 0xFFFFU

struct omnipuck_hello {
    uint32_t session;
    float wheel_speed;        /* rad/s, cap requested */
    float wheel_acceleration; /* rad/s^2, cap requested */
};

struct omnipuck_command {
    uint32_t session;
    uint32_t sent_ms; /* host's clock, modulo 2^32 */
    uint16_t age_ms;
    uint16_t life_ms;
    uint8_t flags; /* enum omnipuck_flag */
    uint8_t cleared;
    uint8_t released;
    uint8_t wheels;                    /* how many were sent */
    float wheel[OMNIPUCK_WHEELS_MAX];  /* rad/s */
};

struct omnipuck_message {
    enum omnipuck_type type;
    union {
        struct omnipuck_hello hello;
        struct omnipuck_command command;
    } of;
};

struct omnipuck_announce {
    uint32_t session;
    uint32_t boot;
    uint8_t capabilities; /* enum omnipuck_capability */
    uint8_t wheels;
    uint16_t longest_life_ms;
    float wheel_speed;        /* rad/s, cap in force */
    float wheel_acceleration; /* rad/s^2, cap in force */
    const char *firmware;     /* the first 12 characters are sent */
};

struct omnipuck_telemetry {
    uint32_t session;
    uint32_t boot;
    uint32_t time_ms; /* device's clock, modulo 2^32 */
    uint16_t status;  /* enum omnipuck_status */
    uint16_t battery_mv;
    int16_t temperature_ddeg; /* 0.1 deg C */
    uint32_t echo_ms;         /* host's clock, modulo 2^32 */
    uint16_t echo_delay_ms;
    uint16_t command_age_ms;
    uint16_t accepted;
    uint16_t dropped;
    uint16_t impacts;
    uint16_t impact_age_ms;
    float impact_x; /* m/s, body frame */
    float impact_y; /* m/s, body frame */
    uint8_t cleared;
    uint8_t released;
    uint8_t wheels;
    float wheel[OMNIPUCK_WHEELS_MAX]; /* rad/s, measured */
};

/* OMNIPUCK_DROP_NONE, or what is wrong with it: type, length or content. */
enum omnipuck_drop omnipuck_message_read(const struct omnipuck_frame *frame, struct omnipuck_message *message);

/* Both return the length of the payload. A float that is not finite is sent as 0: the host would drop the whole frame. */
size_t omnipuck_announce_write(const struct omnipuck_announce *announce, uint8_t *payload);
size_t omnipuck_telemetry_write(const struct omnipuck_telemetry *telemetry, uint8_t *payload);

#endif
