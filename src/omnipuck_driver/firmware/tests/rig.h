/* SPDX-License-Identifier: Apache-2.0 */
/* A firmware on a fake board with a fake clock, and a host that speaks to it. */
#ifndef OMNIPUCK_TEST_RIG_H
#define OMNIPUCK_TEST_RIG_H

#include "firmware.h"
#include "host.h"

enum {
    RIG_WHEELS = 3,
    RIG_BYTES = 1 << 16
};

struct rig {
    struct omnipuck_configuration configuration;
    struct omnipuck_hardware hardware;
    struct omnipuck_state state;

    /* The board. */
    uint32_t clock;
    uint8_t to_device[RIG_BYTES];
    size_t to_device_length;
    size_t to_device_read;
    size_t port_rate; /* bytes the port takes in each millisecond */
    size_t port_room;
    float set[OMNIPUCK_WHEELS_MAX]; /* rad/s */
    float measured[OMNIPUCK_WHEELS_MAX];
    unsigned long sets;
    unsigned long batteries; /* how often it was measured */
    uint16_t battery;
    int16_t temperature;
    bool button;
    bool motor_fault;
    bool too_hot;
    int impacts_waiting;
    float impact_x;
    float impact_y;

    /* The host. */
    uint16_t sequence;
    uint32_t session;
    uint32_t host_ahead; /* ms, host's clock - device's clock, modulo 2^32 */
    uint16_t age;
    uint16_t life;
    uint8_t flags;
    uint8_t cleared;
    uint8_t released;
    float wheel_speed;
    float wheel_acceleration;
    uint8_t from_device[256];
    size_t from_device_length;
    uint16_t device_sequence;
    unsigned long frames;
    unsigned long announces;
    unsigned long telemetries;
    unsigned long bad_frames; /* not whole, of another version, or of an unknown type */
    unsigned long gaps;       /* in the device's numbers */
    struct omnipuck_announce announce;
    char firmware[13];
    struct omnipuck_telemetry telemetry;
};

/* Sets up board and host; the firmware is started by rig_boot. */
void rig_make(struct rig *rig);
void rig_boot(struct rig *rig);

/* rig_make, rig_boot, and a session that is armed and stands. */
void rig_make_armed(struct rig *rig);

void rig_feed(struct rig *rig, const uint8_t *bytes, size_t length);
void rig_feed_frame(struct rig *rig, uint8_t version, uint8_t type, const uint8_t *payload, size_t length);
void rig_hello(struct rig *rig, uint32_t session);
void rig_command(struct rig *rig, float a, float b, float c);

/* One step without time, then steps of 1 ms. */
void rig_run(struct rig *rig, uint32_t ms);

/* The clock goes on, the firmware does not. */
void rig_stall(struct rig *rig, uint32_t ms);

/* A command each 20 ms. */
void rig_drive(struct rig *rig, uint32_t ms, float a, float b, float c);

/* The fastest of the wheels as set [rad/s]. */
float rig_fastest(const struct rig *rig);
bool rig_stands(const struct rig *rig);

/* Runs until telemetry comes and says if its status has this bit. */
bool rig_status(struct rig *rig, unsigned bit);

#endif
