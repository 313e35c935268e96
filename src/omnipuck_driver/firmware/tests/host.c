/* SPDX-License-Identifier: Apache-2.0 */
#include "host.h"

#include <string.h>

/* Four bits at a time, from a table, where the firmware goes bit by bit. */
uint32_t host_crc(const uint8_t *bytes, size_t length)
{
    static const uint32_t table[16] = {
        0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4, 0x4DB26158, 0x5005713C,
        0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C, 0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C,
    };
    uint32_t crc = 0xFFFFFFFF;
    for (size_t i = 0; i < length; ++i) {
        crc = table[(crc ^ bytes[i]) & 15U] ^ (crc >> 4);
        crc = table[(crc ^ (uint32_t)(bytes[i] >> 4)) & 15U] ^ (crc >> 4);
    }
    return crc ^ 0xFFFFFFFF;
}

size_t host_stuff(const uint8_t *bytes, size_t length, uint8_t *stuffed)
{
    size_t to = 0;
    size_t from = 0;
    for (;;) {
        size_t run = 0;
        while (from + run < length && bytes[from + run] != 0 && run < 254) {
            ++run;
        }
        stuffed[to++] = (uint8_t)(run + 1);
        memcpy(stuffed + to, bytes + from, run);
        to += run;
        from += run;
        if (from == length) {
            return to;
        }
        if (run < 254) {
            ++from;
        }
    }
}

bool host_unstuff(const uint8_t *stuffed, size_t length, uint8_t *bytes, size_t *unstuffed)
{
    size_t to = 0;
    size_t left = 0;
    bool zero_due = false;
    for (size_t i = 0; i < length; ++i) {
        if (stuffed[i] == 0) {
            return false;
        }
        if (left > 0) {
            bytes[to++] = stuffed[i];
            --left;
            continue;
        }
        if (zero_due) {
            bytes[to++] = 0;
        }
        left = stuffed[i] - 1U;
        zero_due = stuffed[i] != 255;
    }
    *unstuffed = to;
    return left == 0;
}

static uint8_t *put(uint8_t *to, uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; ++i) {
        *to++ = (uint8_t)(value >> (8 * i) & 255U);
    }
    return to;
}

static uint8_t *put_float(uint8_t *to, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return put(to, bits, 4);
}

static uint32_t get(const uint8_t **from, int bytes)
{
    uint32_t value = 0;
    for (int i = 0; i < bytes; ++i) {
        value |= (uint32_t)*(*from)++ << (8 * i);
    }
    return value;
}

static float get_float(const uint8_t **from)
{
    const uint32_t bits = get(from, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

size_t host_write_frame(uint8_t *frame, uint8_t version, uint8_t type, uint16_t sequence, const uint8_t *payload,
                        size_t length)
{
    uint8_t body[HOST_FRAME_MAX];
    uint8_t *to = put(body, version, 1);
    to = put(to, type, 1);
    to = put(to, sequence, 2);
    memcpy(to, payload, length);
    to += length;
    to = put(to, host_crc(body, (size_t)(to - body)), 4);
    frame[0] = 0;
    const size_t stuffed = host_stuff(body, (size_t)(to - body), frame + 1);
    frame[1 + stuffed] = 0;
    return stuffed + 2;
}

bool host_read_frame(const uint8_t *stuffed, size_t length, struct host_frame *frame)
{
    if (length > 129 || !host_unstuff(stuffed, length, frame->body, &frame->length) || frame->length < 8) {
        return false;
    }
    const uint8_t *crc = frame->body + frame->length - 4;
    if (get(&crc, 4) != host_crc(frame->body, frame->length - 4)) {
        return false;
    }
    const uint8_t *from = frame->body;
    frame->version = (uint8_t)get(&from, 1);
    frame->type = (uint8_t)get(&from, 1);
    frame->sequence = (uint16_t)get(&from, 2);
    frame->payload = from;
    frame->payload_length = frame->length - 8;
    return true;
}

size_t host_write_hello(uint8_t *payload, const struct omnipuck_hello *hello)
{
    uint8_t *to = put(payload, hello->session, 4);
    to = put_float(to, hello->wheel_speed);
    to = put_float(to, hello->wheel_acceleration);
    return (size_t)(to - payload);
}

size_t host_write_command(uint8_t *payload, const struct omnipuck_command *command)
{
    uint8_t *to = put(payload, command->session, 4);
    to = put(to, command->sent_ms, 4);
    to = put(to, command->age_ms, 2);
    to = put(to, command->life_ms, 2);
    to = put(to, command->flags, 1);
    to = put(to, command->cleared, 1);
    to = put(to, command->released, 1);
    to = put(to, command->wheels, 1);
    for (size_t i = 0; i < command->wheels && i < OMNIPUCK_WHEELS_MAX; ++i) {
        to = put_float(to, command->wheel[i]);
    }
    return (size_t)(to - payload);
}

bool host_read_hello(const struct host_frame *frame, struct omnipuck_hello *hello)
{
    const uint8_t *from = frame->payload;
    if (frame->version != 2 || frame->type != 0x01 || frame->payload_length != 12) {
        return false;
    }
    hello->session = get(&from, 4);
    hello->wheel_speed = get_float(&from);
    hello->wheel_acceleration = get_float(&from);
    return true;
}

bool host_read_command(const struct host_frame *frame, struct omnipuck_command *command)
{
    const uint8_t *from = frame->payload;
    if (frame->version != 2 || frame->type != 0x02 || frame->payload_length < 16
        || frame->payload_length != 16U + 4U * from[15]) {
        return false;
    }
    command->session = get(&from, 4);
    command->sent_ms = get(&from, 4);
    command->age_ms = (uint16_t)get(&from, 2);
    command->life_ms = (uint16_t)get(&from, 2);
    command->flags = (uint8_t)get(&from, 1);
    command->cleared = (uint8_t)get(&from, 1);
    command->released = (uint8_t)get(&from, 1);
    command->wheels = (uint8_t)get(&from, 1);
    for (size_t i = 0; i < command->wheels && i < OMNIPUCK_WHEELS_MAX; ++i) {
        command->wheel[i] = get_float(&from);
    }
    return true;
}

bool host_read_announce(const struct host_frame *frame, struct omnipuck_announce *announce, char *firmware)
{
    const uint8_t *from = frame->payload;
    if (frame->version != 2 || frame->type != 0x81 || frame->payload_length != 32) {
        return false;
    }
    announce->session = get(&from, 4);
    announce->boot = get(&from, 4);
    announce->capabilities = (uint8_t)get(&from, 1);
    announce->wheels = (uint8_t)get(&from, 1);
    announce->longest_life_ms = (uint16_t)get(&from, 2);
    announce->wheel_speed = get_float(&from);
    announce->wheel_acceleration = get_float(&from);
    memcpy(firmware, from, 12);
    firmware[12] = '\0';
    announce->firmware = firmware;
    return true;
}

bool host_read_telemetry(const struct host_frame *frame, struct omnipuck_telemetry *telemetry)
{
    const uint8_t *from = frame->payload;
    if (frame->version != 2 || frame->type != 0x82 || frame->payload_length < 45
        || frame->payload_length != 45U + 4U * from[44] || from[44] > OMNIPUCK_WHEELS_MAX) {
        return false;
    }
    telemetry->session = get(&from, 4);
    telemetry->boot = get(&from, 4);
    telemetry->time_ms = get(&from, 4);
    telemetry->status = (uint16_t)get(&from, 2);
    telemetry->battery_mv = (uint16_t)get(&from, 2);
    telemetry->temperature_ddeg = (int16_t)get(&from, 2);
    telemetry->echo_ms = get(&from, 4);
    telemetry->echo_delay_ms = (uint16_t)get(&from, 2);
    telemetry->command_age_ms = (uint16_t)get(&from, 2);
    telemetry->accepted = (uint16_t)get(&from, 2);
    telemetry->dropped = (uint16_t)get(&from, 2);
    telemetry->impacts = (uint16_t)get(&from, 2);
    telemetry->impact_age_ms = (uint16_t)get(&from, 2);
    telemetry->impact_x = get_float(&from);
    telemetry->impact_y = get_float(&from);
    telemetry->cleared = (uint8_t)get(&from, 1);
    telemetry->released = (uint8_t)get(&from, 1);
    telemetry->wheels = (uint8_t)get(&from, 1);
    for (size_t i = 0; i < telemetry->wheels; ++i) {
        telemetry->wheel[i] = get_float(&from);
    }
    return true;
}
