/* SPDX-License-Identifier: Apache-2.0 */
#include "report.h"

/* The value that no age can be is also sent for an age that its field cannot hold. */
static uint16_t age_to_tell(uint32_t age)
{
    return (uint16_t)(age > OMNIPUCK_NO_AGE ? OMNIPUCK_NO_AGE : age);
}

static bool announce(struct omnipuck_state *state, uint32_t session)
{
    const struct omnipuck_configuration *configuration = state->configuration;
    struct omnipuck_announce message;
    message.session = session;
    message.boot = configuration->boot;
    message.capabilities = configuration->capabilities;
    message.wheels = configuration->wheels;
    message.longest_life_ms = configuration->longest_life;
    message.wheel_speed = state->wheel_speed;
    message.wheel_acceleration = state->wheel_acceleration;
    message.firmware = configuration->firmware;
    const size_t length = omnipuck_announce_write(&message, omnipuck_transmitter_payload(&state->transmitter));
    return omnipuck_transmitter_send(&state->transmitter, state->hardware, OMNIPUCK_ANNOUNCE, length);
}

static uint16_t command_age(const struct omnipuck_state *state)
{
    const struct omnipuck_following *following = &state->following;
    return following->active ? age_to_tell(following->age + (state->now - following->since)) : OMNIPUCK_NO_AGE;
}

/* Button, fault and heat count even if noticed only in this step: causes that are over before the telemetry are sent too. */
static uint16_t status(const struct omnipuck_state *state, uint16_t battery)
{
    unsigned bits = state->noticed;
    bits |= state->arming.armed ? OMNIPUCK_STATUS_ARMED : 0U;
    bits |= battery < state->configuration->battery_low ? OMNIPUCK_STATUS_BATTERY_LOW : 0U;
    bits |= state->outlived ? OMNIPUCK_STATUS_OUTLIVED : 0U;
    bits |= state->arming.latched ? OMNIPUCK_STATUS_LATCHED : 0U;
    return (uint16_t)bits;
}

static bool tell(struct omnipuck_state *state)
{
    const struct omnipuck_hardware *hardware = state->hardware;
    struct omnipuck_telemetry message;
    message.session = state->session;
    message.boot = state->configuration->boot;
    message.time_ms = state->now;
    message.battery_mv = hardware->battery(hardware->context);
    message.status = status(state, message.battery_mv);
    message.temperature_ddeg = OMNIPUCK_TEMPERATURE_NOT_MEASURED;
    if ((state->configuration->capabilities & OMNIPUCK_MEASURES_TEMPERATURE) != 0) {
        message.temperature_ddeg = hardware->temperature(hardware->context);
    }
    message.echo_ms = state->echo;
    message.echo_delay_ms = state->echoes ? age_to_tell(state->since_echo) : OMNIPUCK_NO_AGE;
    message.command_age_ms = command_age(state);
    message.accepted = state->decoder.accepted;
    message.dropped = state->decoder.dropped;
    message.impacts = state->impacts;
    message.impact_age_ms = state->impact_sensed ? age_to_tell(state->since_impact) : OMNIPUCK_NO_AGE;
    message.impact_x = state->impact_x;
    message.impact_y = state->impact_y;
    message.cleared = state->arming.cleared;
    message.released = state->arming.released;
    message.wheels = state->configuration->wheels;
    hardware->measure_wheel_speeds(hardware->context, message.wheel, message.wheels);
    const size_t length = omnipuck_telemetry_write(&message, omnipuck_transmitter_payload(&state->transmitter));
    return omnipuck_transmitter_send(&state->transmitter, hardware, OMNIPUCK_TELEMETRY, length);
}

void omnipuck_report(struct omnipuck_state *state)
{
    bool idle = omnipuck_transmitter_flush(&state->transmitter, state->hardware);
    if (idle && state->greeting_due) {
        state->greeting_due = !announce(state, 0);
        idle = omnipuck_transmitter_flush(&state->transmitter, state->hardware);
    }
    if (idle && !state->greeting_due && state->answer_due) {
        state->answer_due = !announce(state, state->session);
        idle = omnipuck_transmitter_flush(&state->transmitter, state->hardware);
    }
    if (idle && state->since_telemetry >= OMNIPUCK_TELEMETRY_PERIOD_MS) {
        /* What is over is kept, so that the rate is steady; whole periods are not made up for, nor is one of which the port
         * takes nothing: battery and wheels would be measured in each step. */
        state->since_telemetry %= OMNIPUCK_TELEMETRY_PERIOD_MS;
        if (tell(state)) {
            state->noticed = 0;
        }
    }
}
