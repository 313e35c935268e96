/* SPDX-License-Identifier: Apache-2.0 */
#include "messages.h"

#include "bytes.h"

enum {
    HELLO_SIZE = 12,
    COMMAND_SIZE_WITHOUT_WHEELS = 16,
    FLOAT_SIZE = 4
};

static bool is_cap(float value)
{
    return omnipuck_is_finite(value) && value > 0.0F;
}

static enum omnipuck_drop hello_read(const uint8_t *payload, size_t length, struct omnipuck_hello *hello)
{
    if (length != HELLO_SIZE) {
        return OMNIPUCK_DROP_LENGTH;
    }
    hello->session = omnipuck_get_u32(payload);
    hello->wheel_speed = omnipuck_get_f32(payload + 4);
    hello->wheel_acceleration = omnipuck_get_f32(payload + 8);
    if (!is_cap(hello->wheel_speed) || !is_cap(hello->wheel_acceleration)) {
        return OMNIPUCK_DROP_CONTENT;
    }
    return OMNIPUCK_DROP_NONE;
}

static enum omnipuck_drop command_read(const uint8_t *payload, size_t length, struct omnipuck_command *command)
{
    if (length < COMMAND_SIZE_WITHOUT_WHEELS) {
        return OMNIPUCK_DROP_LENGTH;
    }
    command->session = omnipuck_get_u32(payload);
    command->sent_ms = omnipuck_get_u32(payload + 4);
    command->age_ms = omnipuck_get_u16(payload + 8);
    command->life_ms = omnipuck_get_u16(payload + 10);
    command->flags = payload[12];
    command->cleared = payload[13];
    command->released = payload[14];
    command->wheels = payload[15];
    if (length != COMMAND_SIZE_WITHOUT_WHEELS + (size_t)command->wheels * FLOAT_SIZE) {
        return OMNIPUCK_DROP_LENGTH;
    }
    if (command->wheels > OMNIPUCK_WHEELS_MAX) {
        return OMNIPUCK_DROP_CONTENT;
    }
    /* Another number of wheels than this device's is a whole frame, if a useless one: all floats are looked at. */
    for (size_t i = 0; i < command->wheels; ++i) {
        const float speed = omnipuck_get_f32(payload + COMMAND_SIZE_WITHOUT_WHEELS + i * FLOAT_SIZE);
        if (!omnipuck_is_finite(speed)) {
            return OMNIPUCK_DROP_CONTENT;
        }
        command->wheel[i] = speed;
    }
    return OMNIPUCK_DROP_NONE;
}

enum omnipuck_drop omnipuck_message_read(const struct omnipuck_frame *frame, struct omnipuck_message *message)
{
    switch (frame->type) {
    case OMNIPUCK_HELLO:
        message->type = OMNIPUCK_HELLO;
        return hello_read(frame->payload, frame->payload_length, &message->of.hello);
    case OMNIPUCK_COMMAND:
        message->type = OMNIPUCK_COMMAND;
        return command_read(frame->payload, frame->payload_length, &message->of.command);
    default:
        return OMNIPUCK_DROP_TYPE;
    }
}

static uint8_t *put_finite(uint8_t *to, float value)
{
    return omnipuck_put_f32(to, omnipuck_is_finite(value) ? value : 0.0F);
}

size_t omnipuck_announce_write(const struct omnipuck_announce *announce, uint8_t *payload)
{
    uint8_t *to = payload;
    to = omnipuck_put_u32(to, announce->session);
    to = omnipuck_put_u32(to, announce->boot);
    to = omnipuck_put_u8(to, announce->capabilities);
    to = omnipuck_put_u8(to, announce->wheels);
    to = omnipuck_put_u16(to, announce->longest_life_ms);
    to = put_finite(to, announce->wheel_speed);
    to = put_finite(to, announce->wheel_acceleration);
    const char *name = announce->firmware;
    for (int i = 0; i < OMNIPUCK_FIRMWARE_NAME_SIZE; ++i) {
        to = omnipuck_put_u8(to, (uint8_t)*name);
        if (*name != '\0') {
            ++name;
        }
    }
    return (size_t)(to - payload);
}

size_t omnipuck_telemetry_write(const struct omnipuck_telemetry *telemetry, uint8_t *payload)
{
    uint8_t *to = payload;
    to = omnipuck_put_u32(to, telemetry->session);
    to = omnipuck_put_u32(to, telemetry->boot);
    to = omnipuck_put_u32(to, telemetry->time_ms);
    to = omnipuck_put_u16(to, telemetry->status);
    to = omnipuck_put_u16(to, telemetry->battery_mv);
    to = omnipuck_put_u16(to, (uint16_t)telemetry->temperature_ddeg);
    to = omnipuck_put_u32(to, telemetry->echo_ms);
    to = omnipuck_put_u16(to, telemetry->echo_delay_ms);
    to = omnipuck_put_u16(to, telemetry->command_age_ms);
    to = omnipuck_put_u16(to, telemetry->accepted);
    to = omnipuck_put_u16(to, telemetry->dropped);
    to = omnipuck_put_u16(to, telemetry->impacts);
    to = omnipuck_put_u16(to, telemetry->impact_age_ms);
    to = put_finite(to, telemetry->impact_x);
    to = put_finite(to, telemetry->impact_y);
    to = omnipuck_put_u8(to, telemetry->cleared);
    to = omnipuck_put_u8(to, telemetry->released);
    to = omnipuck_put_u8(to, telemetry->wheels);
    for (size_t i = 0; i < telemetry->wheels; ++i) {
        to = put_finite(to, telemetry->wheel[i]);
    }
    return (size_t)(to - payload);
}
