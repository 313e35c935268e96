/* SPDX-License-Identifier: Apache-2.0 */
/* What a program needs that plays the board: it holds the firmware in memory whose size it asks for. */
#ifndef OMNIPUCK_HOST_H
#define OMNIPUCK_HOST_H

#include "../firmware.h"

#include <stddef.h>
#include <stdint.h>

size_t omnipuck_host_state_size(void);

/* Telemetry is sent with the next step, whenever the last one was. */
void omnipuck_host_ask_for_telemetry(struct omnipuck_state *state);

/* As if the time between two steps had been too long: a simulated clock does not go on in a stall. */
void omnipuck_host_hold_up(struct omnipuck_state *state);

/* [ms], of the command followed as of the last step, as the driver would count it; 0 where there was none. */
uint32_t omnipuck_host_command_age(const struct omnipuck_state *state);

#endif
