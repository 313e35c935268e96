/* SPDX-License-Identifier: Apache-2.0 */
#include "host.h"

size_t omnipuck_host_state_size(void)
{
    return sizeof(struct omnipuck_state);
}

void omnipuck_host_ask_for_telemetry(struct omnipuck_state *state)
{
    state->since_telemetry = OMNIPUCK_TELEMETRY_PERIOD_MS;
}

void omnipuck_host_hold_up(struct omnipuck_state *state)
{
    state->noticed = (uint16_t)(state->noticed | OMNIPUCK_STATUS_HELD_UP);
}

uint32_t omnipuck_host_command_age(const struct omnipuck_state *state)
{
    const struct omnipuck_following *following = &state->following;
    return following->active ? following->age + (state->now - following->since) : 0;
}
