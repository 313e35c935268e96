/* SPDX-License-Identifier: Apache-2.0 */
#include "rig.h"

#include <math.h>
#include <string.h>

static uint32_t board_clock(void *context)
{
    return ((struct rig *)context)->clock;
}

static size_t board_read(void *context, uint8_t *bytes, size_t capacity)
{
    struct rig *rig = context;
    const size_t waiting = rig->to_device_length - rig->to_device_read;
    const size_t taken = waiting < capacity ? waiting : capacity;
    memcpy(bytes, rig->to_device + rig->to_device_read, taken);
    rig->to_device_read += taken;
    if (rig->to_device_read == rig->to_device_length) {
        rig->to_device_read = 0;
        rig->to_device_length = 0;
    }
    return taken;
}

static void frame_came(struct rig *rig)
{
    struct host_frame frame;
    ++rig->frames;
    if (!host_read_frame(rig->from_device, rig->from_device_length, &frame)) {
        ++rig->bad_frames;
        return;
    }
    if (rig->frames > 1 && frame.sequence != (uint16_t)(rig->device_sequence + 1)) {
        ++rig->gaps;
    }
    rig->device_sequence = frame.sequence;
    if (host_read_announce(&frame, &rig->announce, rig->firmware)) {
        ++rig->announces;
    } else if (host_read_telemetry(&frame, &rig->telemetry)) {
        ++rig->telemetries;
    } else {
        ++rig->bad_frames;
    }
}

static size_t board_write(void *context, const uint8_t *bytes, size_t length)
{
    struct rig *rig = context;
    const size_t taken = length < rig->port_room ? length : rig->port_room;
    rig->port_room -= taken;
    for (size_t i = 0; i < taken; ++i) {
        if (bytes[i] == 0) {
            if (rig->from_device_length > 0) {
                frame_came(rig);
            }
            rig->from_device_length = 0;
        } else if (rig->from_device_length < sizeof rig->from_device) {
            rig->from_device[rig->from_device_length++] = bytes[i];
        }
    }
    return taken;
}

static void board_set_wheel_speeds(void *context, const float *speeds, size_t wheels)
{
    struct rig *rig = context;
    memcpy(rig->set, speeds, wheels * sizeof *speeds);
    ++rig->sets;
}

static void board_measure_wheel_speeds(void *context, float *speeds, size_t wheels)
{
    memcpy(speeds, ((struct rig *)context)->measured, wheels * sizeof *speeds);
}

static uint16_t board_battery(void *context)
{
    struct rig *rig = context;
    ++rig->batteries;
    return rig->battery;
}

static int16_t board_temperature(void *context)
{
    return ((struct rig *)context)->temperature;
}

static bool board_button(void *context)
{
    return ((struct rig *)context)->button;
}

static bool board_motor_fault(void *context)
{
    return ((struct rig *)context)->motor_fault;
}

static bool board_too_hot(void *context)
{
    return ((struct rig *)context)->too_hot;
}

static bool board_take_impact(void *context, float *x, float *y)
{
    struct rig *rig = context;
    if (rig->impacts_waiting == 0) {
        return false;
    }
    --rig->impacts_waiting;
    *x = rig->impact_x;
    *y = rig->impact_y;
    return true;
}

void rig_make(struct rig *rig)
{
    memset(rig, 0, sizeof *rig);
    rig->configuration.wheels = RIG_WHEELS;
    rig->configuration.capabilities = OMNIPUCK_SENSES_IMPACTS;
    rig->configuration.longest_life = 500;
    rig->configuration.battery_low = 6600;
    rig->configuration.wheel_speed = 80.0F;
    rig->configuration.wheel_acceleration = 1000.0F;
    rig->configuration.firmware = "puck 2.0";
    rig->configuration.boot = 7;

    rig->hardware.context = rig;
    rig->hardware.clock = board_clock;
    rig->hardware.read = board_read;
    rig->hardware.write = board_write;
    rig->hardware.set_wheel_speeds = board_set_wheel_speeds;
    rig->hardware.measure_wheel_speeds = board_measure_wheel_speeds;
    rig->hardware.battery = board_battery;
    rig->hardware.temperature = board_temperature;
    rig->hardware.emergency_button_pressed = board_button;
    rig->hardware.motor_fault = board_motor_fault;
    rig->hardware.too_hot = board_too_hot;
    rig->hardware.take_impact = board_take_impact;

    rig->clock = 5000;
    rig->port_rate = RIG_BYTES;
    rig->port_room = RIG_BYTES;
    rig->battery = 7400;
    rig->temperature = 251;
    rig->host_ahead = 0xFFFFFF00U;
    rig->life = 200;
    rig->wheel_speed = 70.5F;
    rig->wheel_acceleration = 500.0F;
}

void rig_boot(struct rig *rig)
{
    /* Memory is not zero when a processor starts. */
    memset(&rig->state, 0xA5, sizeof rig->state);
    omnipuck_start(&rig->state, &rig->configuration, &rig->hardware);
}

void rig_make_armed(struct rig *rig)
{
    rig_make(rig);
    rig_boot(rig);
    rig_hello(rig, 42);
    rig_drive(rig, 20, 0, 0, 0);
    ++rig->released;
    rig_drive(rig, 20, 0, 0, 0);
}

void rig_feed(struct rig *rig, const uint8_t *bytes, size_t length)
{
    if (rig->to_device_length + length <= RIG_BYTES) {
        memcpy(rig->to_device + rig->to_device_length, bytes, length);
        rig->to_device_length += length;
    }
}

void rig_feed_frame(struct rig *rig, uint8_t version, uint8_t type, const uint8_t *payload, size_t length)
{
    uint8_t frame[HOST_FRAME_MAX];
    rig_feed(rig, frame, host_write_frame(frame, version, type, rig->sequence++, payload, length));
}

void rig_hello(struct rig *rig, uint32_t session)
{
    const struct omnipuck_hello hello = {session, rig->wheel_speed, rig->wheel_acceleration};
    uint8_t payload[12];
    rig->session = session;
    rig_feed_frame(rig, 2, 1, payload, host_write_hello(payload, &hello));
}

void rig_command(struct rig *rig, float a, float b, float c)
{
    const struct omnipuck_command command = {
        rig->session, rig->clock + rig->host_ahead, rig->age, rig->life, rig->flags, rig->cleared, rig->released,
        RIG_WHEELS,   {a, b, c, 0, 0, 0, 0, 0}};
    uint8_t payload[16 + 4 * OMNIPUCK_WHEELS_MAX];
    rig_feed_frame(rig, 2, 2, payload, host_write_command(payload, &command));
}

void rig_run(struct rig *rig, uint32_t ms)
{
    omnipuck_step(&rig->state);
    for (uint32_t i = 0; i < ms; ++i) {
        ++rig->clock;
        rig->port_room = rig->port_rate;
        omnipuck_step(&rig->state);
    }
}

void rig_stall(struct rig *rig, uint32_t ms)
{
    rig->clock += ms;
}

void rig_drive(struct rig *rig, uint32_t ms, float a, float b, float c)
{
    for (uint32_t gone = 0; gone < ms; gone += 20) {
        rig_command(rig, a, b, c);
        rig_run(rig, ms - gone < 20 ? ms - gone : 20);
    }
}

float rig_fastest(const struct rig *rig)
{
    float fastest = 0.0F;
    for (size_t i = 0; i < OMNIPUCK_WHEELS_MAX; ++i) {
        fastest = fmaxf(fastest, fabsf(rig->set[i]));
    }
    return fastest;
}

bool rig_stands(const struct rig *rig)
{
    return !(rig_fastest(rig) > 0.0F);
}

bool rig_status(struct rig *rig, unsigned bit)
{
    const unsigned long before = rig->telemetries;
    for (int i = 0; i < 100 && rig->telemetries == before; ++i) {
        rig_run(rig, 1);
    }
    return rig->telemetries > before && (rig->telemetry.status & bit) != 0;
}
