/* SPDX-License-Identifier: Apache-2.0 */
/* The device's side of the serial protocol.
 *
 * All state is in struct omnipuck_state, which the caller owns; nothing is static, so several can run in one process. Its
 * members are for the firmware and for tests to look at, not for a board to set. */
#ifndef OMNIPUCK_FIRMWARE_H
#define OMNIPUCK_FIRMWARE_H

#include "arming.h"
#include "configuration.h"
#include "decoder.h"
#include "delay.h"
#include "hardware.h"
#include "messages.h"
#include "transmitter.h"

#include <stdbool.h>
#include <stdint.h>

enum {
    OMNIPUCK_TELEMETRY_PERIOD_MS = 20,
    OMNIPUCK_SILENCE_MS = 1000,
    /* Between two steps; beyond it the device reports that it was held up, and ramps no further than for this time. */
    OMNIPUCK_HELD_UP_MS = 20,
    /* Motors that nothing has set for so long have stopped by themselves. */
    OMNIPUCK_MOTORS_STOP_MS = 100
};

/* The command that the wheels follow: armed, and not of zero. */
struct omnipuck_following {
    bool active;
    uint32_t since;      /* [ms] it came */
    uint32_t life;       /* [ms] from when it came */
    uint32_t age;        /* [ms] when it came, as the host would count it */
    float wheel[OMNIPUCK_WHEELS_MAX]; /* [rad/s], within the cap of speed */
};

struct omnipuck_state {
    const struct omnipuck_configuration *configuration;
    const struct omnipuck_hardware *hardware;
    struct omnipuck_decoder decoder;
    struct omnipuck_transmitter transmitter;
    struct omnipuck_arming arming;
    struct omnipuck_delay delay;
    struct omnipuck_following following;
    uint32_t now; /* [ms], device's clock at this step */

    uint32_t session;         /* 0: none */
    uint32_t silence;         /* [ms] since the last message of the host in it */
    float wheel_speed;        /* [rad/s], cap in force */
    float wheel_acceleration; /* [rad/s^2], cap in force */
    bool echoes;          /* a command has come in this session */
    uint32_t echo;       /* [ms], `sent` of the newest command */
    uint32_t since_echo; /* [ms] */

    bool button_pressed;
    bool motor_fault;
    bool too_hot;
    bool impact_sensed;
    uint16_t noticed;      /* enum omnipuck_status, what was so at any time since the last telemetry */
    uint16_t impacts;      /* modulo 2^16 */
    uint32_t since_impact; /* [ms] */
    float impact_x;        /* [m/s], body frame */
    float impact_y;        /* [m/s], body frame */

    float speeds[OMNIPUCK_WHEELS_MAX]; /* [rad/s], as set */
    bool outlived;                     /* the last command outlived its life */
    bool greeting_due;                 /* an Announce with session 0 */
    bool answer_due;                   /* an Announce with this session */
    uint32_t since_telemetry;          /* [ms] */
};

/* Once, before the first step. Configuration and hardware are not copied: they must stay, and stay the same. False, and the
 * state not to be used, if the configuration makes no sense, or has a capability without its function. */
bool omnipuck_start(struct omnipuck_state *state, const struct omnipuck_configuration *configuration,
                    const struct omnipuck_hardware *hardware);

/* As often as possible, at least each few milliseconds: reads what came, acts on it, sets the wheels, sends what is due. */
void omnipuck_step(struct omnipuck_state *state);

#endif
