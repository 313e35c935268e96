/* SPDX-License-Identifier: Apache-2.0 */
/* What is different from robot to robot. */
#ifndef OMNIPUCK_CONFIGURATION_H
#define OMNIPUCK_CONFIGURATION_H

#include <stdint.h>

struct omnipuck_configuration {
    uint8_t wheels;            /* 1 to OMNIPUCK_WHEELS_MAX */
    uint8_t capabilities;      /* enum omnipuck_capability */
    uint16_t longest_life;     /* [ms], longer lives of commands are shortened to it; the protocol says 500 */
    uint16_t battery_low;      /* [mV], below it the battery is reported as low; 0: never */
    float wheel_speed;         /* [rad/s], the device's own cap, whatever the host tells */
    float wheel_acceleration;  /* [rad/s^2], the same */
    const char *firmware;      /* ASCII, the first 12 characters are announced */
    uint32_t boot;             /* another number after each start: from the board, by a counter it stores or by chance */
};

#endif
