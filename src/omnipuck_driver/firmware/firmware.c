/* SPDX-License-Identifier: Apache-2.0 */
#include "firmware.h"

#include "bytes.h"
#include "report.h"
#include "wheels.h"

enum {
    READ_CHUNK = 32,
    /* In one step: more than a port of 115200 bit/s brings in 20 ms, and few enough that a flood cannot hold up the step. */
    READ_CHUNKS_MAX = 8
};

/* Ages are counted up, and stop at the end, instead of being differences of clocks: those would be young again after 2^32
 * ms. */
static void pass(uint32_t *age, uint32_t elapsed)
{
    *age = elapsed > UINT32_MAX - *age ? UINT32_MAX : *age + elapsed;
}

static float smaller_cap(float told, float own)
{
    return told < own ? told : own;
}

static bool turns(const float *wheel, size_t wheels)
{
    for (size_t i = 0; i < wheels; ++i) {
        if (wheel[i] != 0.0F) {
            return true;
        }
    }
    return false;
}

static bool has_fault(const struct omnipuck_state *state)
{
    return state->motor_fault || state->too_hot;
}

static void set_wheels(struct omnipuck_state *state)
{
    state->hardware->set_wheel_speeds(state->hardware->context, state->speeds, state->configuration->wheels);
}

/* At once, not in drive: a command that is followed in the same step is to set out from rest. */
static void rest(struct omnipuck_state *state)
{
    const size_t wheels = state->configuration->wheels;
    if (!turns(state->speeds, wheels)) {
        return;
    }
    for (size_t i = 0; i < wheels; ++i) {
        state->speeds[i] = 0.0F;
    }
    set_wheels(state);
}

static void stand(struct omnipuck_state *state)
{
    state->following.active = false;
    rest(state);
}

static void begin_session(struct omnipuck_state *state, uint32_t session, float wheel_speed, float wheel_acceleration)
{
    state->session = session;
    state->silence = 0;
    state->wheel_speed = wheel_speed;
    state->wheel_acceleration = wheel_acceleration;
    state->echoes = false;
    state->echo = 0;
    state->since_echo = 0;
    stand(state);
    omnipuck_arming_new_session(&state->arming);
    omnipuck_delay_forget(&state->delay);
}

static void forget_session(struct omnipuck_state *state)
{
    begin_session(state, 0, state->configuration->wheel_speed, state->configuration->wheel_acceleration);
}

static void note(struct omnipuck_state *state, enum omnipuck_status bit)
{
    state->noticed = (uint16_t)(state->noticed | (unsigned)bit);
}

static void end_life(struct omnipuck_state *state)
{
    const uint32_t elapsed = state->now - state->following.since;
    if (!state->following.active || elapsed < state->following.life) {
        return;
    }
    stand(state);
    state->outlived = true;
    note(state, OMNIPUCK_STATUS_OUTLIVED);
}

static void watch_inputs(struct omnipuck_state *state)
{
    const struct omnipuck_hardware *hardware = state->hardware;
    state->button_pressed = hardware->emergency_button_pressed(hardware->context);
    state->motor_fault = hardware->motor_fault(hardware->context);
    state->too_hot = hardware->too_hot(hardware->context);
    if (state->button_pressed) {
        note(state, OMNIPUCK_STATUS_BUTTON_PRESSED);
        omnipuck_arming_emergency_stop(&state->arming);
        stand(state);
    }
    if (state->motor_fault) {
        note(state, OMNIPUCK_STATUS_MOTOR_FAULT);
    }
    if (state->too_hot) {
        note(state, OMNIPUCK_STATUS_TOO_HOT);
    }
    if (has_fault(state)) {
        omnipuck_arming_disarm(&state->arming);
        stand(state);
    }
    if ((state->configuration->capabilities & OMNIPUCK_SENSES_IMPACTS) != 0
        && hardware->take_impact(hardware->context, &state->impact_x, &state->impact_y)) {
        state->impact_sensed = true;
        ++state->impacts;
        state->since_impact = 0;
    }
}

static void hear_hello(struct omnipuck_state *state, const struct omnipuck_hello *hello)
{
    if (hello->session == 0) {
        forget_session(state);
    } else if (hello->session != state->session) {
        begin_session(state, hello->session, smaller_cap(hello->wheel_speed, state->configuration->wheel_speed),
                      smaller_cap(hello->wheel_acceleration, state->configuration->wheel_acceleration));
    }
    state->silence = 0;
    state->answer_due = true;
}

static void follow(struct omnipuck_state *state, const struct omnipuck_command *command, uint32_t life, uint32_t excess)
{
    struct omnipuck_following *following = &state->following;
    const size_t wheels = state->configuration->wheels;
    if (!state->arming.armed || !turns(command->wheel, wheels)) {
        stand(state);
        return;
    }
    following->active = true;
    following->since = state->now;
    following->life = life;
    following->age = command->age_ms + excess;
    for (size_t i = 0; i < wheels; ++i) {
        following->wheel[i] = command->wheel[i];
    }
    omnipuck_wheels_cap(following->wheel, wheels, state->wheel_speed);
    state->outlived = false;
}

static void hear_command(struct omnipuck_state *state, const struct omnipuck_command *command)
{
    if (state->session == 0 || command->session != state->session) {
        return;
    }
    if (command->wheels != state->configuration->wheels) {
        return;
    }
    state->silence = 0;

    const uint32_t longest = state->configuration->longest_life;
    const uint32_t life = command->life_ms < longest ? command->life_ms : longest;
    uint32_t excess;
    const bool clock_good = omnipuck_delay_measure(&state->delay, command->sent_ms, state->now, &excess);
    if (!clock_good || excess >= life) {
        if (!clock_good) {
            /* The device may as well have been held up for as long, and the commands that wait behind this one be as old. */
            omnipuck_arming_disarm(&state->arming);
        }
        omnipuck_arming_flags(&state->arming, command->flags);
        if (!state->arming.armed) {
            stand(state);
        }
        return;
    }
    state->echoes = true;
    state->echo = command->sent_ms;
    state->since_echo = 0;
    omnipuck_arming_command(&state->arming, command->flags, command->cleared, command->released, state->button_pressed,
                            has_fault(state));
    follow(state, command, life - excess, excess);
}

static void hear(struct omnipuck_state *state, uint8_t byte)
{
    struct omnipuck_message message;
    switch (omnipuck_decoder_feed(&state->decoder, byte, &message)) {
    case OMNIPUCK_HEARD_MESSAGE:
        if (message.type == OMNIPUCK_HELLO) {
            hear_hello(state, &message.of.hello);
        } else {
            hear_command(state, &message.of.command);
        }
        break;
    case OMNIPUCK_HEARD_OTHER_VERSION:
        state->greeting_due = true;
        break;
    case OMNIPUCK_HEARD_NOTHING:
    case OMNIPUCK_HEARD_DROPPED:
        break;
    }
}

static void listen(struct omnipuck_state *state)
{
    uint8_t bytes[READ_CHUNK];
    for (int chunk = 0; chunk < READ_CHUNKS_MAX; ++chunk) {
        const size_t came = state->hardware->read(state->hardware->context, bytes, READ_CHUNK);
        for (size_t i = 0; i < came && i < READ_CHUNK; ++i) {
            hear(state, bytes[i]);
        }
        if (came < READ_CHUNK) {
            return;
        }
    }
}

static void drive(struct omnipuck_state *state, uint32_t elapsed)
{
    const size_t wheels = state->configuration->wheels;
    float before[OMNIPUCK_WHEELS_MAX];
    float wanted[OMNIPUCK_WHEELS_MAX];
    for (size_t i = 0; i < wheels; ++i) {
        before[i] = state->speeds[i];
        wanted[i] = state->following.active ? state->following.wheel[i] : 0.0F;
    }
    /* After a stall the whole of it would be a jump. */
    const uint32_t ramped = elapsed < OMNIPUCK_HELD_UP_MS ? elapsed : OMNIPUCK_HELD_UP_MS;
    omnipuck_wheels_ramp(state->speeds, wanted, wheels, state->wheel_acceleration, (float)ramped * 0.001F);

    bool changed = false;
    for (size_t i = 0; i < wheels; ++i) {
        changed = changed || state->speeds[i] != before[i];
    }
    /* Steps may be many in a millisecond, and a bus to the motors slow. */
    if (changed || elapsed > 0) {
        set_wheels(state);
    }
}

static bool is_able(const struct omnipuck_configuration *configuration, const struct omnipuck_hardware *hardware)
{
    return ((configuration->capabilities & OMNIPUCK_SENSES_IMPACTS) == 0 || hardware->take_impact != NULL)
           && ((configuration->capabilities & OMNIPUCK_MEASURES_TEMPERATURE) == 0 || hardware->temperature != NULL);
}

static bool makes_sense(const struct omnipuck_configuration *configuration)
{
    return configuration->wheels >= 1 && configuration->wheels <= OMNIPUCK_WHEELS_MAX && configuration->longest_life > 0
           && omnipuck_is_finite(configuration->wheel_speed) && configuration->wheel_speed > 0.0F
           && omnipuck_is_finite(configuration->wheel_acceleration) && configuration->wheel_acceleration > 0.0F
           && configuration->firmware != NULL;
}

bool omnipuck_start(struct omnipuck_state *state, const struct omnipuck_configuration *configuration,
                    const struct omnipuck_hardware *hardware)
{
    if (!makes_sense(configuration) || !is_able(configuration, hardware)) {
        return false;
    }
    state->configuration = configuration;
    state->hardware = hardware;
    state->now = hardware->clock(hardware->context);
    omnipuck_decoder_start(&state->decoder);
    omnipuck_transmitter_start(&state->transmitter);
    omnipuck_arming_start(&state->arming);
    for (size_t i = 0; i < OMNIPUCK_WHEELS_MAX; ++i) {
        state->speeds[i] = 0.0F;
    }
    state->following.since = state->now;
    state->following.life = 0;
    state->following.age = 0;
    forget_session(state);
    state->outlived = false;
    state->button_pressed = false;
    state->motor_fault = false;
    state->too_hot = false;
    state->impact_sensed = false;
    state->impacts = 0;
    state->since_impact = 0;
    state->impact_x = 0.0F;
    state->impact_y = 0.0F;
    state->noticed = 0;
    state->greeting_due = true;
    state->answer_due = false;
    state->since_telemetry = OMNIPUCK_TELEMETRY_PERIOD_MS;
    set_wheels(state);
    return true;
}

void omnipuck_step(struct omnipuck_state *state)
{
    const uint32_t now = state->hardware->clock(state->hardware->context);
    const uint32_t elapsed = now - state->now;
    state->now = now;
    if (elapsed > OMNIPUCK_HELD_UP_MS) {
        note(state, OMNIPUCK_STATUS_HELD_UP);
    }
    if (elapsed >= OMNIPUCK_MOTORS_STOP_MS) {
        rest(state);
    }
    pass(&state->silence, elapsed);
    pass(&state->since_echo, elapsed);
    pass(&state->since_impact, elapsed);
    pass(&state->since_telemetry, elapsed);
    omnipuck_delay_pass(&state->delay, elapsed);

    /* Before listening: after a stall the wheels have outlived their command, even if a fresh one is there by now. */
    end_life(state);
    watch_inputs(state);
    listen(state);
    /* After listening: a host that spoke during a stall of the device was not silent. */
    if (state->session != 0 && state->silence >= OMNIPUCK_SILENCE_MS) {
        forget_session(state);
    }
    drive(state, elapsed);
    omnipuck_report(state);
}
