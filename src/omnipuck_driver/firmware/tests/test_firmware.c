/* SPDX-License-Identifier: Apache-2.0 */
/* Each rule of the protocol's page, on a fake board with a fake clock. */
#include "cobs.h"
#include "crc32.h"
#include "decoder.h"
#include "delay.h"
#include "rig.h"
#include "wheels.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static unsigned long checks;
static unsigned long failures;
static struct rig rig;
static struct rig other;

static void check(bool holds, const char *what, int line)
{
    ++checks;
    if (!holds) {
        ++failures;
        printf("line %d: not so: %s\n", line, what);
    }
}

#define CHECK(condition) check((condition), #condition, __LINE__)

static bool near(float a, float b)
{
    return fabsf(a - b) <= 1e-4F * fmaxf(1.0F, fabsf(b));
}

static bool wheels_near(float a, float b, float c)
{
    return near(rig.set[0], a) && near(rig.set[1], b) && near(rig.set[2], c);
}

static bool armed(void)
{
    return rig_status(&rig, OMNIPUCK_STATUS_ARMED);
}

static bool latched(void)
{
    return rig_status(&rig, OMNIPUCK_STATUS_LATCHED);
}

/* The examples of the page, byte for byte. */

static const uint8_t hello_bytes[] = {0x00, 0x04, 0x02, 0x01, 0x07, 0x02, 0x2a, 0x01, 0x01, 0x01, 0x01, 0x03,
                                      0x8d, 0x42, 0x01, 0x07, 0xfa, 0x43, 0xb5, 0x39, 0xb0, 0xc4, 0x00};
static const uint8_t drive_bytes[] = {0x00, 0x04, 0x02, 0x02, 0x08, 0x02, 0x2a, 0x01, 0x01, 0x03, 0xe8, 0x03, 0x01,
                                      0x02, 0x14, 0x02, 0xb4, 0x01, 0x01, 0x03, 0x01, 0x03, 0x01, 0x03, 0xc8, 0xc1,
                                      0x01, 0x01, 0x01, 0x01, 0x01, 0x07, 0xc8, 0x41, 0x3a, 0xbf, 0xb2, 0x93, 0x00};
static const uint8_t stop_bytes[] = {0x00, 0x04, 0x02, 0x02, 0x09, 0x02, 0x2a, 0x01, 0x01, 0x03, 0xfc, 0x03, 0x01,
                                     0x01, 0x01, 0x02, 0xc8, 0x02, 0x01, 0x03, 0x01, 0x03, 0x01, 0x01, 0x01, 0x01,
                                     0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x05, 0xe1, 0xf4, 0x41, 0xaa, 0x00};
static const uint8_t hold_bytes[] = {0x00, 0x04, 0x02, 0x02, 0x0a, 0x02, 0x2a, 0x01, 0x01, 0x03, 0x10, 0x04, 0x01,
                                     0x01, 0x01, 0x02, 0xc8, 0x05, 0x02, 0x01, 0x01, 0x03, 0x01, 0x01, 0x01, 0x01,
                                     0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x05, 0x09, 0x75, 0xd2, 0x26, 0x00};
static const uint8_t announce_bytes[] = {0x00, 0x03, 0x02, 0x81, 0x01, 0x02, 0x2a, 0x01, 0x01, 0x02, 0x07,
                                         0x01, 0x01, 0x05, 0x01, 0x03, 0xf4, 0x01, 0x01, 0x03, 0x8d, 0x42,
                                         0x01, 0x0b, 0xfa, 0x43, 0x70, 0x75, 0x63, 0x6b, 0x20, 0x32, 0x2e,
                                         0x30, 0x01, 0x01, 0x01, 0x05, 0x81, 0xb1, 0xe1, 0x49, 0x00};
static const uint8_t telemetry_bytes[] = {
    0x00, 0x04, 0x02, 0x82, 0x01, 0x02, 0x2a, 0x01, 0x01, 0x02, 0x07, 0x01, 0x01, 0x03, 0x88, 0x13, 0x01,
    0x02, 0x01, 0x07, 0xe8, 0x1c, 0xff, 0x7f, 0xe8, 0x03, 0x01, 0x02, 0x05, 0x02, 0x19, 0x02, 0x03, 0x02,
    0x01, 0x02, 0x02, 0x03, 0x2c, 0x01, 0x01, 0x01, 0x02, 0xbf, 0x01, 0x03, 0x80, 0x3e, 0x03, 0x01, 0x03,
    0x01, 0x03, 0xc0, 0xc1, 0x01, 0x01, 0x01, 0x01, 0x01, 0x07, 0xc0, 0x41, 0xa3, 0x36, 0x96, 0x37, 0x00};

static enum omnipuck_heard feed(struct omnipuck_decoder *decoder, const uint8_t *bytes, size_t length,
                                struct omnipuck_message *message)
{
    enum omnipuck_heard heard = OMNIPUCK_HEARD_NOTHING;
    for (size_t i = 0; i < length; ++i) {
        const enum omnipuck_heard now = omnipuck_decoder_feed(decoder, bytes[i], message);
        heard = now == OMNIPUCK_HEARD_NOTHING ? heard : now;
    }
    return heard;
}

static bool host_writes(const uint8_t *bytes, size_t length, uint8_t type, uint16_t sequence, const uint8_t *payload,
                        size_t payload_length)
{
    uint8_t frame[HOST_FRAME_MAX];
    return host_write_frame(frame, 2, type, sequence, payload, payload_length) == length
           && memcmp(frame, bytes, length) == 0;
}

static bool device_writes(const uint8_t *bytes, size_t length, uint8_t type, uint16_t sequence, const uint8_t *payload,
                          size_t payload_length)
{
    uint8_t frame[OMNIPUCK_FRAME_MAX];
    memcpy(frame + OMNIPUCK_PAYLOAD_AT, payload, payload_length);
    return omnipuck_frame_close(frame, type, sequence, payload_length) == length && memcmp(frame, bytes, length) == 0;
}

static void check_command_example(const uint8_t *bytes, size_t length, uint16_t sequence,
                                  const struct omnipuck_command *want)
{
    struct omnipuck_decoder decoder;
    struct omnipuck_message message;
    uint8_t payload[64];
    omnipuck_decoder_start(&decoder);
    CHECK(feed(&decoder, bytes, length, &message) == OMNIPUCK_HEARD_MESSAGE);
    CHECK(message.type == OMNIPUCK_COMMAND && decoder.sequence == sequence);
    const struct omnipuck_command *got = &message.of.command;
    CHECK(got->session == want->session && got->sent_ms == want->sent_ms && got->age_ms == want->age_ms);
    CHECK(got->life_ms == want->life_ms && got->flags == want->flags && got->cleared == want->cleared);
    CHECK(got->released == want->released && got->wheels == want->wheels);
    CHECK(memcmp(got->wheel, want->wheel, want->wheels * sizeof(float)) == 0);
    const size_t payload_length = host_write_command(payload, got);
    CHECK(host_writes(bytes, length, 0x02, sequence, payload, payload_length));
    CHECK(device_writes(bytes, length, 0x02, sequence, payload, payload_length));
}

static void test_examples_of_the_host(void)
{
    struct omnipuck_decoder decoder;
    struct omnipuck_message message;
    uint8_t payload[64];
    omnipuck_decoder_start(&decoder);
    CHECK(feed(&decoder, hello_bytes, sizeof hello_bytes, &message) == OMNIPUCK_HEARD_MESSAGE);
    CHECK(message.type == OMNIPUCK_HELLO && decoder.sequence == 7 && message.of.hello.session == 42);
    CHECK(near(message.of.hello.wheel_speed, 70.5F) && near(message.of.hello.wheel_acceleration, 500.0F));
    const size_t length = host_write_hello(payload, &message.of.hello);
    CHECK(host_writes(hello_bytes, sizeof hello_bytes, 0x01, 7, payload, length));
    CHECK(device_writes(hello_bytes, sizeof hello_bytes, 0x01, 7, payload, length));

    const struct omnipuck_command drive = {42, 1000, 20, 180, 0, 0, 1, 3, {-25, 0, 25, 0, 0, 0, 0, 0}};
    const struct omnipuck_command stop = {42, 1020, 0, 200, 1, 0, 1, 3, {0, 0, 0, 0, 0, 0, 0, 0}};
    const struct omnipuck_command hold = {42, 1040, 0, 200, 2, 1, 1, 3, {0, 0, 0, 0, 0, 0, 0, 0}};
    check_command_example(drive_bytes, sizeof drive_bytes, 8, &drive);
    check_command_example(stop_bytes, sizeof stop_bytes, 9, &stop);
    check_command_example(hold_bytes, sizeof hold_bytes, 10, &hold);
}

static void test_examples_of_the_device(void)
{
    uint8_t payload[OMNIPUCK_PAYLOAD_MAX];
    struct host_frame frame;
    const struct omnipuck_announce announce = {42, 7, 1, 3, 500, 70.5F, 500.0F, "puck 2.0"};
    size_t length = omnipuck_announce_write(&announce, payload);
    CHECK(device_writes(announce_bytes, sizeof announce_bytes, 0x81, 0, payload, length));
    struct omnipuck_announce heard;
    char firmware[13];
    CHECK(host_read_frame(announce_bytes + 1, sizeof announce_bytes - 2, &frame) && frame.sequence == 0);
    CHECK(host_read_announce(&frame, &heard, firmware) && heard.session == 42 && heard.boot == 7);
    CHECK(heard.capabilities == 1 && heard.wheels == 3 && heard.longest_life_ms == 500);
    CHECK(near(heard.wheel_speed, 70.5F) && near(heard.wheel_acceleration, 500) && strcmp(firmware, "puck 2.0") == 0);

    const struct omnipuck_telemetry telemetry = {
        42, 7, 5000, OMNIPUCK_STATUS_ARMED, 7400, OMNIPUCK_TEMPERATURE_NOT_MEASURED, 1000, 5, 25, 3, 1, 2, 300,
        -0.5F, 0.25F, 0, 1, 3, {-24, 0, 24, 0, 0, 0, 0, 0}};
    length = omnipuck_telemetry_write(&telemetry, payload);
    CHECK(device_writes(telemetry_bytes, sizeof telemetry_bytes, 0x82, 1, payload, length));
    struct omnipuck_telemetry told;
    CHECK(host_read_frame(telemetry_bytes + 1, sizeof telemetry_bytes - 2, &frame) && frame.sequence == 1);
    CHECK(host_read_telemetry(&frame, &told) && told.session == 42 && told.boot == 7 && told.time_ms == 5000);
    CHECK(told.status == 1 && told.battery_mv == 7400 && told.temperature_ddeg == 0x7FFF && told.echo_ms == 1000);
    CHECK(told.echo_delay_ms == 5 && told.command_age_ms == 25 && told.accepted == 3 && told.dropped == 1);
    CHECK(told.impacts == 2 && told.impact_age_ms == 300 && near(told.impact_x, -0.5F) && near(told.impact_y, 0.25F));
    CHECK(told.cleared == 0 && told.released == 1 && told.wheels == 3 && near(told.wheel[2], 24.0F));
}

/* The page's commands, on a whole device: stopped, latched, cleared by the change of the count in the last of them. */
static void test_examples_on_a_device(void)
{
    rig_make(&rig);
    rig_boot(&rig);
    rig_feed(&rig, hello_bytes, sizeof hello_bytes);
    rig_feed(&rig, drive_bytes, sizeof drive_bytes);
    rig_run(&rig, 20);
    CHECK(rig.announce.session == 42 && near(rig.announce.wheel_speed, 70.5F));
    CHECK(rig_stands(&rig) && !armed());
    rig_feed(&rig, stop_bytes, sizeof stop_bytes);
    CHECK(latched());
    rig_feed(&rig, hold_bytes, sizeof hold_bytes);
    CHECK(!latched() && !armed());
    CHECK(rig.telemetry.cleared == 1 && rig.telemetry.released == 1 && rig.telemetry.echo_ms == 1040);
    CHECK(rig.telemetry.accepted == 4 && rig.telemetry.dropped == 0);
}

static uint32_t random_state = 1;

static uint32_t random_below(uint32_t limit)
{
    random_state = random_state * 1664525U + 1013904223U;
    return (random_state >> 8) % limit;
}

static void test_cobs_and_crc(void)
{
    CHECK(omnipuck_crc32((const uint8_t *)"123456789", 9) == 0xCBF43926U);
    CHECK(host_crc((const uint8_t *)"123456789", 9) == 0xCBF43926U);
    CHECK(omnipuck_crc32((const uint8_t *)"", 0) == 0);

    uint8_t body[256];
    uint8_t in_place[257];
    uint8_t stuffed[300];
    for (int round = 0; round < 20000; ++round) {
        const size_t length = random_below(254);
        const uint32_t kinds = 1 + random_below(256);
        for (size_t i = 0; i < length; ++i) {
            body[i] = (uint8_t)random_below(kinds);
            in_place[1 + i] = body[i];
        }
        omnipuck_cobs_encode(in_place, length);
        const bool same = host_stuff(body, length, stuffed) == length + 1
                          && memcmp(stuffed, in_place, length + 1) == 0;
        size_t decoded = length + 1;
        const bool back = memchr(in_place, 0, length + 1) == NULL && omnipuck_cobs_decode(in_place, &decoded)
                          && decoded == length && memcmp(in_place, body, length) == 0;
        if (!same || !back) {
            CHECK(same);
            CHECK(back);
            return;
        }
    }
    CHECK(true);

    uint8_t beyond[] = {3, 1};
    size_t length = sizeof beyond;
    CHECK(!omnipuck_cobs_decode(beyond, &length));
    uint8_t with_zero[] = {1, 0};
    length = sizeof with_zero;
    CHECK(!omnipuck_cobs_decode(with_zero, &length));
    uint8_t only_zero[] = {1, 1};
    length = sizeof only_zero;
    CHECK(omnipuck_cobs_decode(only_zero, &length) && length == 1 && only_zero[0] == 0);
}

/* One frame to a decoder that has heard the page's Hello; says why it was dropped. */
static enum omnipuck_drop drop_of(const uint8_t *bytes, size_t length)
{
    struct omnipuck_decoder decoder;
    struct omnipuck_message message;
    omnipuck_decoder_start(&decoder);
    feed(&decoder, hello_bytes, sizeof hello_bytes, &message);
    feed(&decoder, bytes, length, &message);
    if (decoder.accepted == 2 && decoder.dropped == 0) {
        return OMNIPUCK_DROP_NONE;
    }
    for (int reason = 1; reason < OMNIPUCK_DROP_REASONS; ++reason) {
        if (decoder.drops[reason] == 1 && decoder.dropped == 1 && decoder.accepted == 1) {
            return (enum omnipuck_drop)reason;
        }
    }
    return OMNIPUCK_DROP_REASONS;
}

static enum omnipuck_drop drop_of_frame(uint8_t version, uint8_t type, uint16_t sequence, const uint8_t *payload,
                                        size_t length)
{
    uint8_t frame[HOST_FRAME_MAX];
    return drop_of(frame, host_write_frame(frame, version, type, sequence, payload, length));
}

static void test_frames_that_are_dropped(void)
{
    uint8_t bytes[HOST_FRAME_MAX];
    uint8_t payload[200];
    memset(payload, 1, sizeof payload);

    memcpy(bytes, drive_bytes, sizeof drive_bytes);
    CHECK(drop_of(bytes, sizeof drive_bytes) == OMNIPUCK_DROP_NONE);
    for (size_t i = 1; i + 1 < sizeof drive_bytes; ++i) {
        for (unsigned bit = 0; bit < 8; ++bit) {
            memcpy(bytes, drive_bytes, sizeof drive_bytes);
            bytes[i] = (uint8_t)(bytes[i] ^ (1U << bit));
            struct omnipuck_decoder decoder;
            struct omnipuck_message message;
            omnipuck_decoder_start(&decoder);
            CHECK(feed(&decoder, bytes, sizeof drive_bytes, &message) == OMNIPUCK_HEARD_DROPPED);
        }
    }
    bytes[0] = 0;
    bytes[1] = 5;
    bytes[2] = 1;
    bytes[3] = 0;
    CHECK(drop_of(bytes, 4) == OMNIPUCK_DROP_COBS);
    bytes[1] = 2;
    CHECK(drop_of(bytes, 4) == OMNIPUCK_DROP_TOO_SHORT);
    bytes[1] = 1;
    bytes[2] = 0;
    CHECK(drop_of(bytes, 3) == OMNIPUCK_DROP_TOO_SHORT);
    CHECK(drop_of_frame(1, 2, 8, payload, 28) == OMNIPUCK_DROP_VERSION);
    CHECK(drop_of_frame(3, 77, 8, payload, 5) == OMNIPUCK_DROP_VERSION);
    CHECK(drop_of_frame(2, 3, 8, payload, 28) == OMNIPUCK_DROP_TYPE);
    CHECK(drop_of_frame(2, 0x82, 8, payload, 57) == OMNIPUCK_DROP_TYPE);
    CHECK(drop_of_frame(2, 1, 8, payload, 11) == OMNIPUCK_DROP_LENGTH);
    CHECK(drop_of_frame(2, 1, 8, payload, 13) == OMNIPUCK_DROP_LENGTH);
    CHECK(drop_of_frame(2, 2, 8, payload, 0) == OMNIPUCK_DROP_LENGTH);
    CHECK(drop_of_frame(2, 2, 8, payload, 15) == OMNIPUCK_DROP_LENGTH);
    CHECK(drop_of_frame(2, 2, 8, payload, 16) == OMNIPUCK_DROP_LENGTH);
    CHECK(drop_of_frame(2, 2, 8, payload, 20) == OMNIPUCK_DROP_NONE);
    CHECK(drop_of_frame(2, 2, 8, payload, 21) == OMNIPUCK_DROP_LENGTH);
    /* Eight wheels at most, whatever a body has room for. */
    payload[15] = 8;
    CHECK(drop_of_frame(2, 2, 8, payload, 48) == OMNIPUCK_DROP_NONE);
    payload[15] = 9;
    CHECK(drop_of_frame(2, 2, 8, payload, 52) == OMNIPUCK_DROP_CONTENT);
    payload[15] = 26;
    CHECK(drop_of_frame(2, 2, 8, payload, 120) == OMNIPUCK_DROP_CONTENT);
    payload[15] = 27;
    CHECK(drop_of_frame(2, 2, 8, payload, 124) == OMNIPUCK_DROP_TOO_LONG);
    payload[15] = 26;
    memcpy(payload + 116, "\x00\x00\x80\x7f", 4);
    CHECK(drop_of_frame(2, 2, 8, payload, 120) == OMNIPUCK_DROP_CONTENT);

    static const uint8_t not_finite[3][4] = {{0, 0, 0x80, 0x7F}, {0, 0, 0x80, 0xFF}, {1, 0, 0xC0, 0x7F}};
    for (int i = 0; i < 3; ++i) {
        memset(payload, 1, sizeof payload);
        memcpy(payload + 16, not_finite[i], 4);
        CHECK(drop_of_frame(2, 2, 8, payload, 20) == OMNIPUCK_DROP_CONTENT);
        memset(payload, 1, sizeof payload);
        memcpy(payload + 4, not_finite[i], 4);
        CHECK(drop_of_frame(2, 1, 8, payload, 12) == OMNIPUCK_DROP_CONTENT);
        memset(payload, 1, sizeof payload);
        memcpy(payload + 8, not_finite[i], 4);
        CHECK(drop_of_frame(2, 1, 8, payload, 12) == OMNIPUCK_DROP_CONTENT);
    }
}

static void test_noise_and_zeros(void)
{
    struct omnipuck_decoder decoder;
    struct omnipuck_message message;
    uint8_t noise[1000];
    memset(noise, 0x55, sizeof noise);
    omnipuck_decoder_start(&decoder);
    CHECK(feed(&decoder, noise, sizeof noise, &message) == OMNIPUCK_HEARD_NOTHING);
    CHECK(feed(&decoder, hello_bytes, sizeof hello_bytes, &message) == OMNIPUCK_HEARD_MESSAGE);
    CHECK(decoder.drops[OMNIPUCK_DROP_TOO_LONG] == 1 && decoder.dropped == 1 && decoder.accepted == 1);
    memset(noise, 0, sizeof noise);
    CHECK(feed(&decoder, noise, sizeof noise, &message) == OMNIPUCK_HEARD_NOTHING);
    CHECK(decoder.dropped == 1);
    /* Without the first 00, as one that the frame before has ended with. */
    CHECK(feed(&decoder, drive_bytes + 1, sizeof drive_bytes - 1, &message) == OMNIPUCK_HEARD_MESSAGE);
    CHECK(feed(&decoder, noise, 10, &message) == OMNIPUCK_HEARD_NOTHING && decoder.accepted == 2);
}

static bool takes_number(struct omnipuck_decoder *decoder, uint8_t type, uint16_t sequence)
{
    uint8_t payload[20];
    uint8_t frame[HOST_FRAME_MAX];
    struct omnipuck_message message;
    memset(payload, 1, sizeof payload);
    const size_t length = host_write_frame(frame, 2, type, sequence, payload, type == 1 ? 12 : 20);
    return feed(decoder, frame, length, &message) == OMNIPUCK_HEARD_MESSAGE;
}

static void test_sequence(void)
{
    struct omnipuck_decoder decoder;
    omnipuck_decoder_start(&decoder);
    CHECK(takes_number(&decoder, 2, 60000));
    CHECK(!takes_number(&decoder, 2, 60000));
    CHECK(!takes_number(&decoder, 2, 59999));
    CHECK(!takes_number(&decoder, 2, 60000 - 32767));
    CHECK(!takes_number(&decoder, 2, 60000 - 32768));
    CHECK(decoder.drops[OMNIPUCK_DROP_REPETITION] == 4);
    CHECK(takes_number(&decoder, 2, 60001));
    CHECK(takes_number(&decoder, 2, 65535));
    CHECK(takes_number(&decoder, 2, 0));
    CHECK(!takes_number(&decoder, 2, 65535));
    CHECK(takes_number(&decoder, 2, 32767));
    CHECK(!takes_number(&decoder, 2, 32766));
    /* A Hello begins anew, wherever. */
    CHECK(takes_number(&decoder, 1, 5));
    CHECK(takes_number(&decoder, 1, 5));
    CHECK(!takes_number(&decoder, 2, 5));
    CHECK(!takes_number(&decoder, 2, 4));
    CHECK(takes_number(&decoder, 2, 6));
    /* A frame that is dropped for another reason takes no number. */
    struct omnipuck_message message;
    uint8_t payload[20] = {0};
    uint8_t frame[HOST_FRAME_MAX];
    feed(&decoder, frame, host_write_frame(frame, 2, 9, 100, payload, 20), &message);
    CHECK(takes_number(&decoder, 2, 7));
}

static void test_delay(void)
{
    struct omnipuck_delay delay;
    uint32_t excess = 77;
    const uint32_t start = 0xFFFFFFF0U;
    omnipuck_delay_forget(&delay);
    CHECK(omnipuck_delay_measure(&delay, 10, start, &excess) && excess == 0);
    CHECK(omnipuck_delay_measure(&delay, 20, start + 13, &excess) && excess == 3);
    CHECK(omnipuck_delay_measure(&delay, 30, start + 18, &excess) && excess == 0);
    CHECK(omnipuck_delay_measure(&delay, 30, start + 20, &excess) && excess == 2);
    omnipuck_delay_pass(&delay, 999);
    CHECK(omnipuck_delay_measure(&delay, 30, start + 20, &excess) && excess == 2);
    omnipuck_delay_pass(&delay, 1);
    CHECK(omnipuck_delay_measure(&delay, 30, start + 20, &excess) && excess == 1);
    omnipuck_delay_pass(&delay, 1500);
    CHECK(omnipuck_delay_measure(&delay, 30, start + 20, &excess) && excess == 0);
    CHECK(omnipuck_delay_measure(&delay, 30, start + 5020, &excess) && excess == 5000);
    CHECK(!omnipuck_delay_measure(&delay, 30, start + 5021, &excess));
    CHECK(omnipuck_delay_measure(&delay, 30, start + 5023, &excess) && excess == 2);
    CHECK(omnipuck_delay_measure(&delay, 30 + 0x7FFF0000U, start, &excess) && excess == 0);
    omnipuck_delay_forget(&delay);
    CHECK(omnipuck_delay_measure(&delay, 0, 0x90000000U, &excess) && excess == 0);
}

static void test_wheels(void)
{
    float speeds[3] = {-100, 50, 0};
    omnipuck_wheels_cap(speeds, 3, 70);
    CHECK(near(speeds[0], -70) && near(speeds[1], 35) && near(speeds[2], 0));
    float huge[2] = {3e38F, -3e38F};
    omnipuck_wheels_cap(huge, 2, 70.5F);
    CHECK(near(huge[0], 70.5F) && near(huge[1], -70.5F));
    omnipuck_wheels_cap(huge, 2, 0);
    CHECK(near(huge[0], 0) && near(huge[1], 0));

    float now[3] = {0, 0, 0};
    const float wanted[3] = {-10, 5, 0};
    omnipuck_wheels_ramp(now, wanted, 3, 500, 0.01F);
    CHECK(near(now[0], -5) && near(now[1], 2.5F) && near(now[2], 0));
    omnipuck_wheels_ramp(now, wanted, 3, 500, 0.0F);
    CHECK(near(now[0], -5) && near(now[1], 2.5F));
    omnipuck_wheels_ramp(now, wanted, 3, 500, 0.02F);
    CHECK(near(now[0], -10) && near(now[1], 5));
    /* Slower at once, the other way from standing. */
    const float back[3] = {5, 1, 0};
    omnipuck_wheels_ramp(now, back, 3, 500, 0.0F);
    CHECK(near(now[0], 0) && near(now[1], 1));
    omnipuck_wheels_ramp(now, back, 3, 500, 0.005F);
    CHECK(near(now[0], 2.5F) && near(now[1], 1));
    const float zero[3] = {0, 0, 0};
    omnipuck_wheels_ramp(now, zero, 3, 500, 0.0F);
    CHECK(near(now[0], 0) && near(now[1], 0) && near(now[2], 0));
}

static void test_configuration(void)
{
    rig_make(&rig);
    CHECK(omnipuck_start(&rig.state, &rig.configuration, &rig.hardware));
    CHECK(rig.sets == 1 && rig_stands(&rig));
    rig.configuration.wheels = 0;
    CHECK(!omnipuck_start(&rig.state, &rig.configuration, &rig.hardware));
    rig.configuration.wheels = 9;
    CHECK(!omnipuck_start(&rig.state, &rig.configuration, &rig.hardware));
    rig.configuration.wheels = 8;
    CHECK(omnipuck_start(&rig.state, &rig.configuration, &rig.hardware));
    rig.configuration.wheel_speed = INFINITY;
    CHECK(!omnipuck_start(&rig.state, &rig.configuration, &rig.hardware));
    rig.configuration.wheel_speed = NAN;
    CHECK(!omnipuck_start(&rig.state, &rig.configuration, &rig.hardware));
    rig.configuration.wheel_speed = 80;
    rig.configuration.longest_life = 0;
    CHECK(!omnipuck_start(&rig.state, &rig.configuration, &rig.hardware));
    /* A capability whose function is not there. */
    rig_make(&rig);
    rig.hardware.take_impact = NULL;
    CHECK(!omnipuck_start(&rig.state, &rig.configuration, &rig.hardware));
    rig.configuration.capabilities = OMNIPUCK_MEASURES_TEMPERATURE;
    CHECK(omnipuck_start(&rig.state, &rig.configuration, &rig.hardware));
    rig.hardware.temperature = NULL;
    CHECK(!omnipuck_start(&rig.state, &rig.configuration, &rig.hardware));
    rig.configuration.capabilities = 0;
    CHECK(omnipuck_start(&rig.state, &rig.configuration, &rig.hardware));
}

static void test_start_and_telemetry_without_a_session(void)
{
    rig_make(&rig);
    rig_boot(&rig);
    rig_run(&rig, 0);
    CHECK(rig.announces == 1 && rig.announce.session == 0 && rig.announce.boot == 7);
    CHECK(near(rig.announce.wheel_speed, 80) && near(rig.announce.wheel_acceleration, 1000));
    CHECK(rig.telemetries == 1 && rig.telemetry.session == 0 && rig.telemetry.boot == 7);
    CHECK(rig.device_sequence == 1);
    rig_run(&rig, 1000);
    CHECK(rig.telemetries == 51 && rig.announces == 1 && rig.gaps == 0 && rig.bad_frames == 0);
    CHECK(rig.telemetry.status == 0 && rig.telemetry.time_ms == 6000 && rig.telemetry.battery_mv == 7400);
    CHECK(rig.telemetry.temperature_ddeg == 0x7FFF && rig.telemetry.command_age_ms == 0xFFFF);
    CHECK(rig.telemetry.echo_ms == 0 && rig.telemetry.echo_delay_ms == 0xFFFF);
    CHECK(rig.telemetry.impact_age_ms == 0xFFFF && rig.telemetry.wheels == 3);
    CHECK(rig.sets == 1001 && rig_stands(&rig));
}

static void test_hello(void)
{
    rig_make(&rig);
    rig_boot(&rig);
    rig_run(&rig, 5);
    rig_hello(&rig, 42);
    rig_run(&rig, 0);
    CHECK(rig.announces == 2 && rig.announce.session == 42 && rig.announce.wheels == 3);
    CHECK(near(rig.announce.wheel_speed, 70.5F) && near(rig.announce.wheel_acceleration, 500));
    CHECK(rig.announce.longest_life_ms == 500 && rig.announce.capabilities == 1 && strcmp(rig.firmware, "puck 2.0") == 0);
    rig_hello(&rig, 42);
    rig_run(&rig, 0);
    CHECK(rig.announces == 3 && rig.announce.session == 42);
    /* Larger caps than the device's own. */
    rig.wheel_speed = 1e9F;
    rig.wheel_acceleration = 1e9F;
    rig_hello(&rig, 43);
    rig_run(&rig, 0);
    CHECK(rig.announce.session == 43);
    CHECK(near(rig.announce.wheel_speed, 80) && near(rig.announce.wheel_acceleration, 1000));
    /* A cap that is not above 0 is none: the frame is dropped. */
    rig.wheel_speed = -1;
    rig_hello(&rig, 44);
    rig_run(&rig, 0);
    CHECK(rig.announce.session == 43);
    rig.wheel_speed = 1e9F;
    /* 0 is no session. */
    rig_hello(&rig, 0);
    rig_run(&rig, 20);
    CHECK(rig.announce.session == 0 && rig.telemetry.session == 0 && near(rig.announce.wheel_speed, 80));
    ++rig.released;
    rig_drive(&rig, 60, 0, 0, 0);
    ++rig.released;
    rig_drive(&rig, 60, 0, 0, 0);
    CHECK(!armed() && rig.telemetry.echo_delay_ms == 0xFFFF);
    CHECK(rig.bad_frames == 0);
}

/* "on a Hello with a session that is new to it, stands still, disarms and forgets the old one" */
static void test_new_session_while_driving(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 200, 10, 0, -10);
    CHECK(wheels_near(10, 0, -10) && armed());
    rig_hello(&rig, 42);
    rig_run(&rig, 1);
    CHECK(wheels_near(10, 0, -10) && rig.announce.session == 42);
    const uint32_t old = rig.session;
    rig_hello(&rig, 43);
    rig_run(&rig, 0);
    CHECK(rig_stands(&rig) && rig.announce.session == 43);
    CHECK(!armed() && rig.telemetry.session == 43 && rig.telemetry.released == 0 && rig.telemetry.echo_ms == 0);
    rig.session = old;
    rig_drive(&rig, 100, 10, 0, -10);
    ++rig.released;
    rig_drive(&rig, 100, 0, 0, 0);
    CHECK(!armed() && rig_stands(&rig) && rig.telemetry.echo_ms == 0);
    /* Of the first command of a session it is not known when its counts changed. */
    rig.session = 43;
    rig_drive(&rig, 100, 0, 0, 0);
    CHECK(!armed() && rig.telemetry.released == rig.released);
    ++rig.released;
    rig_drive(&rig, 40, 0, 0, 0);
    CHECK(armed());
}

static void test_arming(void)
{
    rig_make(&rig);
    rig_boot(&rig);
    rig_hello(&rig, 42);
    rig.released = 255;
    rig_drive(&rig, 1000, 0, 0, 0);
    CHECK(!armed() && rig.telemetry.released == 255);
    rig_drive(&rig, 500, 5, 5, 5);
    CHECK(!armed() && rig_stands(&rig));
    rig.released = 0;
    rig_command(&rig, 0, 0, 0);
    rig_run(&rig, 1);
    CHECK(armed());
    rig_drive(&rig, 200, 5, 5, 5);
    CHECK(wheels_near(5, 5, 5));
    /* A hold stops at once, disarms, and its own change of the count arms nothing. */
    rig.flags = OMNIPUCK_FLAG_HOLD;
    ++rig.released;
    rig_command(&rig, 5, 5, 5);
    rig_run(&rig, 0);
    CHECK(rig_stands(&rig) && !armed());
    rig_drive(&rig, 100, 0, 0, 0);
    rig.flags = 0;
    rig_drive(&rig, 100, 0, 0, 0);
    CHECK(!armed());
    ++rig.released;
    rig_drive(&rig, 40, 0, 0, 0);
    CHECK(armed());
    /* Flags that do not exist are not looked at. */
    rig.flags = OMNIPUCK_FLAG_HOLD;
    rig_drive(&rig, 20, 0, 0, 0);
    rig.flags = 0x80;
    ++rig.released;
    rig_drive(&rig, 40, 0, 0, 0);
    CHECK(armed());
    rig.flags = 0;
}

/* "The count stays in every later command, so a lost frame loses nothing, and a frame that comes late cannot arm what was
 * disarmed since." */
static void test_arming_with_lost_and_late_frames(void)
{
    rig_make_armed(&rig);
    rig.flags = OMNIPUCK_FLAG_HOLD;
    rig_drive(&rig, 40, 0, 0, 0);
    rig.flags = 0;
    ++rig.released;
    ++rig.sequence;
    ++rig.sequence;
    rig_drive(&rig, 40, 0, 0, 0);
    CHECK(armed());

    /* A command that arms, 300 ms in a buffer; a button was pressed meanwhile. */
    rig.button = true;
    rig_run(&rig, 20);
    rig.button = false;
    ++rig.cleared;
    rig_drive(&rig, 20, 0, 0, 0);
    CHECK(!latched() && !armed());
    ++rig.released;
    rig_command(&rig, 0, 0, 0);
    rig_stall(&rig, 300);
    rig_run(&rig, 0);
    CHECK(!armed());
    /* The count is still in the commands that follow in time. */
    rig_drive(&rig, 20, 0, 0, 0);
    CHECK(armed());
}

static void test_emergency_stop_of_the_host(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 200, 10, 0, -10);
    CHECK(wheels_near(10, 0, -10));
    rig.flags = OMNIPUCK_FLAG_EMERGENCY_STOP;
    rig_command(&rig, 10, 0, -10);
    rig_run(&rig, 0);
    CHECK(rig_stands(&rig));
    CHECK(latched() && !armed() && !rig_status(&rig, OMNIPUCK_STATUS_BUTTON_PRESSED));
    rig_drive(&rig, 100, 0, 0, 0);
    /* Without the flag it stays, and a release does nothing. */
    rig.flags = 0;
    ++rig.released;
    rig_drive(&rig, 100, 0, 0, 0);
    CHECK(latched() && !armed());
    /* New sessions leave it latched, and their first counts do nothing. */
    rig_hello(&rig, 99);
    ++rig.cleared;
    rig_drive(&rig, 100, 0, 0, 0);
    CHECK(latched() && rig.telemetry.session == 99 && rig.telemetry.cleared == rig.cleared);
    /* A change together with bit 0 clears nothing. */
    rig.flags = OMNIPUCK_FLAG_EMERGENCY_STOP;
    ++rig.cleared;
    rig_drive(&rig, 40, 0, 0, 0);
    rig.flags = 0;
    rig_drive(&rig, 40, 0, 0, 0);
    CHECK(latched());
    /* With the hold it does: the host is held when it clears. */
    rig.flags = OMNIPUCK_FLAG_HOLD;
    ++rig.cleared;
    rig_drive(&rig, 40, 0, 0, 0);
    CHECK(!latched() && !armed());
    rig.flags = 0;
    rig_drive(&rig, 40, 0, 0, 0);
    CHECK(!armed());
    ++rig.released;
    rig_drive(&rig, 40, 0, 0, 0);
    CHECK(armed());
    /* Cleared and released by one command, as where the one between was lost. */
    rig.flags = OMNIPUCK_FLAG_EMERGENCY_STOP;
    rig_drive(&rig, 40, 0, 0, 0);
    rig.flags = 0;
    ++rig.cleared;
    ++rig.released;
    rig_drive(&rig, 60, 0, 0, 0);
    CHECK(!latched() && armed());
    CHECK(rig_stands(&rig));
}

static void test_emergency_button(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 200, 10, 0, -10);
    rig.button = true;
    rig_command(&rig, 10, 0, -10);
    rig_run(&rig, 0);
    CHECK(rig_stands(&rig));
    CHECK(latched() && !armed() && rig_status(&rig, OMNIPUCK_STATUS_BUTTON_PRESSED));
    ++rig.cleared;
    rig_drive(&rig, 100, 0, 0, 0);
    CHECK(latched());
    rig.button = false;
    ++rig.released;
    rig_drive(&rig, 100, 0, 0, 0);
    CHECK(latched() && !armed() && !rig_status(&rig, OMNIPUCK_STATUS_BUTTON_PRESSED));
    ++rig.cleared;
    rig_drive(&rig, 40, 0, 0, 0);
    CHECK(!latched() && !armed());
    ++rig.released;
    rig_drive(&rig, 40, 0, 0, 0);
    CHECK(armed());
    /* It needs no session, and silence does not end it. */
    rig_run(&rig, 2000);
    CHECK(rig.telemetry.session == 0);
    rig.button = true;
    rig_run(&rig, 1);
    rig.button = false;
    CHECK(latched());
    rig_run(&rig, 3000);
    CHECK(latched());
    rig_boot(&rig);
    CHECK(!latched() && !armed());
}

static void test_late_stop_is_heeded(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 100, 10, 0, -10);
    rig.life = 500;
    rig_command(&rig, 10, 0, -10);
    rig_run(&rig, 10);
    rig.flags = OMNIPUCK_FLAG_EMERGENCY_STOP;
    rig.host_ahead -= 1000;
    rig_command(&rig, 0, 0, 0);
    rig.host_ahead += 1000;
    rig_run(&rig, 0);
    CHECK(rig_stands(&rig) && latched() && !armed());
}

static void test_caps(void)
{
    rig_make_armed(&rig);
    /* 500 rad/s^2: 0.5 rad/s each ms, all alike. */
    rig_command(&rig, -40, 20, 0);
    rig_run(&rig, 0);
    CHECK(wheels_near(0, 0, 0));
    rig_run(&rig, 1);
    CHECK(wheels_near(-0.5F, 0.25F, 0));
    rig_run(&rig, 9);
    CHECK(wheels_near(-5, 2.5F, 0));
    rig_drive(&rig, 100, -40, 20, 0);
    CHECK(wheels_near(-40, 20, 0));
    rig_command(&rig, -30, 21, 0);
    rig_run(&rig, 0);
    CHECK(wheels_near(-30, 20, 0));
    rig_run(&rig, 2);
    CHECK(wheels_near(-30, 21, 0));
    rig_command(&rig, 0, 0, 0);
    rig_run(&rig, 0);
    CHECK(wheels_near(0, 0, 0));
    CHECK(armed());
    /* Speed, all alike. */
    rig_drive(&rig, 500, -141, 70.5F, 0);
    CHECK(wheels_near(-70.5F, 35.25F, 0));
    rig_drive(&rig, 500, 3e38F, -3e38F, 1e38F);
    CHECK(near(rig.set[0], 70.5F) && near(rig.set[1], -70.5F) && rig_fastest(&rig) <= 70.5F);

    /* After a stall no jump of all that was missed. */
    rig_make_armed(&rig);
    rig.life = 500;
    rig_command(&rig, 60, 0, 0);
    rig_run(&rig, 0);
    rig_stall(&rig, 100);
    rig_run(&rig, 0);
    CHECK(wheels_near(10, 0, 0));
}

/* "wheels whose command has outlived its life meanwhile, or that nothing has set for 100 ms, set out from 0 again" */
static void test_no_jump_after_a_stall(void)
{
    static const struct {
        uint16_t life;
        uint32_t stall;
        bool outlives;
    } cases[] = {{50, 60, true}, {200, 250, true}, {500, 100, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        rig_make_armed(&rig);
        rig_drive(&rig, 200, 60, 0, 0);
        rig.life = cases[i].life;
        rig_command(&rig, 60, 0, 0);
        rig_run(&rig, 1);
        CHECK(wheels_near(60, 0, 0) && !rig_status(&rig, OMNIPUCK_STATUS_OUTLIVED));
        rig_command(&rig, 60, 0, 0);
        rig_run(&rig, 1);
        /* A fresh command is there when the device goes on. */
        rig_stall(&rig, cases[i].stall);
        rig.life = 200;
        rig_command(&rig, 60, 0, 0);
        rig_run(&rig, 0);
        CHECK(wheels_near(10, 0, 0));
        rig_run(&rig, 1);
        CHECK(wheels_near(10.5F, 0, 0));
        CHECK(((rig.telemetry.status & OMNIPUCK_STATUS_OUTLIVED) != 0) == cases[i].outlives);
        CHECK((rig.telemetry.status & OMNIPUCK_STATUS_HELD_UP) != 0);
        CHECK(!rig_status(&rig, OMNIPUCK_STATUS_OUTLIVED) && armed());
    }

    /* A stop is one, though a command follows in the same step. */
    rig_make_armed(&rig);
    rig_drive(&rig, 200, 60, 0, 0);
    rig_command(&rig, 0, 0, 0);
    rig_command(&rig, 60, 0, 0);
    rig_run(&rig, 0);
    CHECK(rig_stands(&rig));
    rig_run(&rig, 1);
    CHECK(wheels_near(0.5F, 0, 0) && armed());
}

static void test_life(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 200, 10, 0, -10);
    rig.age = 120;
    rig.life = 80;
    rig_command(&rig, 10, 0, -10);
    rig_run(&rig, 79);
    CHECK(wheels_near(10, 0, -10));
    rig_run(&rig, 1);
    CHECK(rig_stands(&rig));
    CHECK(rig_status(&rig, OMNIPUCK_STATUS_OUTLIVED) && armed() && rig.telemetry.command_age_ms == 0xFFFF);
    /* A fresh one is followed without arming anew. */
    rig.age = 0;
    rig.life = 200;
    rig_drive(&rig, 100, 5, 5, 5);
    CHECK(wheels_near(5, 5, 5) && !rig_status(&rig, OMNIPUCK_STATUS_OUTLIVED));
    /* The device's longest life. */
    rig.life = 60000;
    rig_command(&rig, 5, 5, 5);
    rig_run(&rig, 499);
    CHECK(wheels_near(5, 5, 5));
    rig_run(&rig, 1);
    CHECK(rig_stands(&rig) && armed());
    /* No life, no motion. */
    rig.life = 0;
    rig_drive(&rig, 100, 5, 5, 5);
    CHECK(rig_stands(&rig));
}

/* "So neither a full buffer nor a stall makes an old command move the robot." */
static void test_time_on_the_way(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 100, 10, 0, -10);
    /* 150 ms longer on the way than the fastest: 50 of 200 ms are left. */
    rig_run(&rig, 300);
    CHECK(rig_stands(&rig));
    rig.host_ahead -= 150;
    rig_command(&rig, 10, 0, -10);
    rig.host_ahead += 150;
    rig_run(&rig, 30);
    CHECK(wheels_near(10, 0, -10));
    CHECK(rig.telemetry.command_age_ms >= 150 && rig.telemetry.command_age_ms < 200);
    rig_run(&rig, 20);
    CHECK(rig_stands(&rig));
    /* 200 ms: nothing is left, but it has come. */
    const uint32_t sent = rig.clock + rig.host_ahead - 200;
    rig.host_ahead -= 200;
    rig_command(&rig, 10, 0, -10);
    rig.host_ahead += 200;
    rig_run(&rig, 30);
    CHECK(rig_stands(&rig) && rig.telemetry.echo_ms == sent);
    /* A stall of 560 ms with commands in the buffer, the newest 200 ms old. */
    rig_drive(&rig, 100, 10, 0, -10);
    for (int i = 0; i < 19; ++i) {
        rig_command(&rig, 10, 0, -10);
        rig_stall(&rig, 20);
    }
    rig_stall(&rig, 180);
    rig_run(&rig, 4);
    CHECK(rig_stands(&rig));
    CHECK((rig.telemetry.status & OMNIPUCK_STATUS_HELD_UP) != 0);
    CHECK(!rig_status(&rig, OMNIPUCK_STATUS_HELD_UP));

    /* Drift: the smallest delay rises by 1 ms per second, so a host's clock that is slow by less is forgiven. */
    rig_make_armed(&rig);
    rig.life = 5;
    for (int second = 0; second < 20; ++second) {
        rig_drive(&rig, 1000, 0, 0, 0);
        rig.host_ahead -= 1;
    }
    rig_command(&rig, 1, 1, 1);
    rig_run(&rig, 3);
    CHECK(wheels_near(1, 1, 1));
}

static void test_clocks(void)
{
    /* Both clocks run over 2^32 while the robot drives. */
    rig_make(&rig);
    rig.clock = 0xFFFFFF00U;
    rig.host_ahead = 0x40U;
    rig_boot(&rig);
    rig_hello(&rig, 42);
    rig_drive(&rig, 20, 0, 0, 0);
    ++rig.released;
    rig_drive(&rig, 20, 0, 0, 0);
    rig_drive(&rig, 60, 5, 0, 0);
    for (int i = 0; i < 30; ++i) {
        rig_drive(&rig, 20, 5, 0, 0);
        if (!wheels_near(5, 0, 0)) {
            CHECK(wheels_near(5, 0, 0));
        }
    }
    CHECK(rig.clock < 0x1000U && armed());

    /* The host's clock was set back by 6 s: one command is dropped, it disarms, and the next is measured anew. */
    rig_run(&rig, 300);
    rig.host_ahead -= 6000;
    rig_command(&rig, 5, 0, 0);
    rig_run(&rig, 15);
    CHECK(rig_stands(&rig));
    rig_command(&rig, 5, 0, 0);
    rig_run(&rig, 15);
    CHECK(rig_stands(&rig) && !armed());
    ++rig.released;
    rig_drive(&rig, 20, 0, 0, 0);
    rig_command(&rig, 5, 0, 0);
    rig_run(&rig, 15);
    CHECK(wheels_near(5, 0, 0));
    /* And on by 6 s: the fastest there was. */
    rig_run(&rig, 300);
    rig.host_ahead += 6000;
    rig_command(&rig, 5, 0, 0);
    rig_run(&rig, 15);
    CHECK(wheels_near(5, 0, 0));

    /* Ages stay old for longer than 2^32 ms. */
    rig_make(&rig);
    rig_boot(&rig);
    rig.impacts_waiting = 1;
    rig_run(&rig, 1);
    for (int i = 0; i < 3; ++i) {
        rig_stall(&rig, 0x60000000U);
        rig_run(&rig, 20);
        CHECK(rig.telemetry.impact_age_ms == 0xFFFF);
    }
}

static void test_commands_that_are_dropped(void)
{
    rig_make_armed(&rig);
    /* Another number of wheels. */
    const struct omnipuck_command two = {42, rig.clock + rig.host_ahead, 0, 200, 1, 9, 9, 2, {5, 5, 0, 0, 0, 0, 0, 0}};
    uint8_t payload[64];
    rig_feed_frame(&rig, 2, 2, payload, host_write_command(payload, &two));
    rig_run(&rig, 20);
    CHECK(rig_stands(&rig) && armed() && !latched() && rig.telemetry.released == 1);
    /* A repetition. */
    rig_command(&rig, 5, 5, 5);
    --rig.sequence;
    rig_run(&rig, 19);
    const uint16_t dropped = rig.telemetry.dropped;
    rig_command(&rig, -5, -5, -5);
    rig_run(&rig, 40);
    CHECK(wheels_near(5, 5, 5) && rig.telemetry.dropped == (uint16_t)(dropped + 1));
}

static void test_faults(void)
{
    for (int which = 0; which < 2; ++which) {
        rig_make_armed(&rig);
        rig_drive(&rig, 100, 10, 0, -10);
        bool *fault = which == 0 ? &rig.motor_fault : &rig.too_hot;
        const unsigned bit = which == 0 ? OMNIPUCK_STATUS_MOTOR_FAULT : OMNIPUCK_STATUS_TOO_HOT;
        *fault = true;
        rig_command(&rig, 10, 0, -10);
        rig_run(&rig, 0);
        CHECK(rig_stands(&rig));
        CHECK(!armed() && rig_status(&rig, bit) && !latched());
        ++rig.released;
        rig_drive(&rig, 100, 10, 0, -10);
        CHECK(!armed() && rig_stands(&rig));
        *fault = false;
        rig_drive(&rig, 100, 10, 0, -10);
        CHECK(!armed() && rig_stands(&rig) && !rig_status(&rig, bit));
        ++rig.released;
        rig_drive(&rig, 100, 0, 0, 0);
        CHECK(armed());
    }
}

/* Whether it lasts or not: what stopped the robot is told. */
static void test_causes_shorter_than_a_period(void)
{
    bool *const inputs[] = {&rig.button, &rig.motor_fault, &rig.too_hot};
    static const unsigned bits[] = {OMNIPUCK_STATUS_BUTTON_PRESSED, OMNIPUCK_STATUS_MOTOR_FAULT, OMNIPUCK_STATUS_TOO_HOT};
    for (size_t i = 0; i < sizeof bits / sizeof *bits; ++i) {
        rig_make_armed(&rig);
        rig_drive(&rig, 100, 10, 0, -10);
        CHECK(!rig_status(&rig, bits[i]));
        *inputs[i] = true;
        rig_run(&rig, 1);
        *inputs[i] = false;
        rig_run(&rig, 1);
        CHECK(rig_stands(&rig) && rig_status(&rig, bits[i]));
        CHECK(!rig_status(&rig, bits[i]) && !armed());
    }
}

static void test_battery_and_temperature(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 100, 10, 0, -10);
    rig.battery = 6599;
    rig_drive(&rig, 100, 10, 0, -10);
    CHECK(wheels_near(10, 0, -10) && armed() && rig_status(&rig, OMNIPUCK_STATUS_BATTERY_LOW));
    CHECK(rig.telemetry.battery_mv == 6599);
    rig.battery = 6600;
    rig_run(&rig, 40);
    CHECK(!rig_status(&rig, OMNIPUCK_STATUS_BATTERY_LOW));

    rig_make(&rig);
    rig.configuration.capabilities = OMNIPUCK_MEASURES_TEMPERATURE;
    rig.hardware.take_impact = NULL;
    rig.temperature = -51;
    rig_boot(&rig);
    rig_run(&rig, 20);
    CHECK(rig.telemetry.temperature_ddeg == -51 && rig.announce.capabilities == 2);
}

static void test_impacts_and_measured_wheels(void)
{
    rig_make_armed(&rig);
    rig.impact_x = -0.5F;
    rig.impact_y = 0.25F;
    rig.impacts_waiting = 2;
    rig_run(&rig, 300);
    CHECK(rig.telemetry.impacts == 2 && near(rig.telemetry.impact_x, -0.5F) && near(rig.telemetry.impact_y, 0.25F));
    CHECK(rig.telemetry.impact_age_ms >= 279 && rig.telemetry.impact_age_ms <= 300);
    rig_run(&rig, 100000);
    CHECK(rig.telemetry.impacts == 2 && rig.telemetry.impact_age_ms == 0xFFFF);
    rig.measured[0] = -24;
    rig.measured[1] = NAN;
    rig.measured[2] = 24;
    rig.impact_x = INFINITY;
    rig.impacts_waiting = 1;
    rig_run(&rig, 40);
    CHECK(near(rig.telemetry.wheel[0], -24) && near(rig.telemetry.wheel[1], 0) && near(rig.telemetry.wheel[2], 24));
    CHECK(rig.telemetry.impacts == 3 && near(rig.telemetry.impact_x, 0) && near(rig.telemetry.impact_y, 0.25F));
}

static void test_silence(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 100, 10, 0, -10);
    rig_command(&rig, 10, 0, -10);
    rig_run(&rig, 199);
    CHECK(wheels_near(10, 0, -10));
    rig_run(&rig, 1);
    CHECK(rig_stands(&rig));
    rig_run(&rig, 770);
    CHECK(armed() && rig.telemetry.session == 42 && rig.telemetry.echo_delay_ms >= 960);
    rig_run(&rig, 50);
    CHECK(!armed() && rig.telemetry.session == 0 && rig.telemetry.released == 0 && rig.telemetry.echo_delay_ms == 0xFFFF);
    CHECK(rig_status(&rig, OMNIPUCK_STATUS_OUTLIVED));
    rig_drive(&rig, 200, 10, 0, -10);
    ++rig.released;
    rig_drive(&rig, 200, 0, 0, 0);
    CHECK(!armed() && rig_stands(&rig) && rig.telemetry.session == 0);
    rig_hello(&rig, 42);
    rig_drive(&rig, 100, 0, 0, 0);
    CHECK(rig.telemetry.session == 42 && !armed() && rig_status(&rig, OMNIPUCK_STATUS_OUTLIVED));
}

/* A host that goes on is not silent, though the device did not listen for longer than a second. */
static void test_own_stall(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 100, 10, 0, -10);
    rig_stall(&rig, 1500);
    rig_command(&rig, 10, 0, -10);
    rig_run(&rig, 0);
    CHECK((rig.telemetry.status & OMNIPUCK_STATUS_HELD_UP) != 0 && rig.telemetry.session == 42);
    rig_stall(&rig, 20);
    rig_run(&rig, 0);
    CHECK(!rig_status(&rig, OMNIPUCK_STATUS_HELD_UP));
    rig_stall(&rig, 21);
    CHECK(rig_status(&rig, OMNIPUCK_STATUS_HELD_UP));
    CHECK(!rig_status(&rig, OMNIPUCK_STATUS_HELD_UP));

    /* So long that it may have been a clock: none of the old commands is followed, the second as little as the first. */
    rig_make_armed(&rig);
    rig_drive(&rig, 100, 10, 0, -10);
    for (int i = 0; i < 15; ++i) {
        rig_command(&rig, 10, 0, -10);
        rig_stall(&rig, 20);
    }
    rig_stall(&rig, 5500);
    for (int i = 0; i < 30; ++i) {
        rig_run(&rig, 1);
        CHECK(rig_stands(&rig));
    }
    CHECK(!armed() && rig.telemetry.session == 42);
}

static void test_other_version(void)
{
    uint8_t payload[28] = {42};
    rig_make_armed(&rig);
    rig_drive(&rig, 100, 10, 0, -10);
    const unsigned long announces = rig.announces;
    const uint16_t dropped = rig.telemetry.dropped;
    rig_feed_frame(&rig, 1, 2, payload, sizeof payload);
    --rig.sequence;
    rig_run(&rig, 1);
    CHECK(rig.announces == announces + 1 && rig.announce.session == 0 && rig.announce.boot == 7);
    CHECK(wheels_near(10, 0, -10));
    rig_drive(&rig, 60, 10, 0, -10);
    CHECK(armed() && rig.telemetry.dropped == (uint16_t)(dropped + 1) && rig.announces == announces + 1);
    /* Damaged, it is nobody's version. */
    uint8_t frame[HOST_FRAME_MAX];
    const size_t length = host_write_frame(frame, 1, 2, 500, payload, sizeof payload);
    frame[4] ^= 0x10;
    rig_feed(&rig, frame, length);
    rig_run(&rig, 40);
    CHECK(rig.announces == announces + 1 && rig.telemetry.dropped == (uint16_t)(dropped + 2));

    rig_make(&rig);
    rig_boot(&rig);
    rig_run(&rig, 10);
    rig_feed_frame(&rig, 9, 200, payload, 0);
    rig_run(&rig, 1);
    CHECK(rig.announces == 2 && rig.announce.session == 0 && rig_stands(&rig));
}

static void test_garbage(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 100, 10, 0, -10);
    const uint16_t accepted = rig.telemetry.accepted;
    uint8_t garbage[5000];
    for (size_t i = 0; i < sizeof garbage; ++i) {
        garbage[i] = (uint8_t)random_below(256);
    }
    rig_feed(&rig, garbage, sizeof garbage);
    rig_run(&rig, 40);
    CHECK(rig.telemetry.accepted == accepted && rig.telemetry.dropped > 5);
    CHECK(wheels_near(10, 0, -10) && armed());
    rig_drive(&rig, 100, 5, 0, -5);
    CHECK(wheels_near(5, 0, -5));
}

static void test_cable_pulled(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 100, 10, 0, -10);
    rig_command(&rig, 10, 0, -10);
    rig_run(&rig, 3);
    rig.port_rate = 0;
    rig_run(&rig, 196);
    CHECK(wheels_near(10, 0, -10));
    rig_run(&rig, 1);
    CHECK(rig_stands(&rig));
    const unsigned long batteries = rig.batteries;
    rig_run(&rig, 1000);
    const unsigned long before = rig.telemetries;
    CHECK(rig.batteries <= batteries + 50);
    rig.port_rate = RIG_BYTES;
    rig_run(&rig, 20);
    /* What is told is what is true now, not what was when the cable was pulled. */
    CHECK(rig.telemetries == before + 1 && rig.clock - rig.telemetry.time_ms < 20 && rig.telemetry.session == 0);
    CHECK(rig.gaps == 0 && rig.bad_frames == 0);
}

static void test_slow_port(void)
{
    /* 115200 bit/s: 12 bytes in a millisecond at most. */
    rig_make(&rig);
    rig.port_rate = 11;
    rig.port_room = 11;
    rig_boot(&rig);
    rig_run(&rig, 1000);
    CHECK(rig.telemetries >= 49 && rig.announces == 1 && rig.bad_frames == 0 && rig.gaps == 0);
    /* One byte in a millisecond: fewer, but whole ones. */
    rig.port_rate = 1;
    const unsigned long before = rig.telemetries;
    rig_run(&rig, 100);
    rig_hello(&rig, 42);
    rig_run(&rig, 900);
    CHECK(rig.telemetries >= before + 10 && rig.telemetries <= before + 15 && rig.announces == 2);
    CHECK(rig.bad_frames == 0 && rig.gaps == 0 && rig.announce.session == 42);
    /* Closed from the start: the greeting is the first that comes. */
    rig_make(&rig);
    rig.port_rate = 0;
    rig.port_room = 0;
    rig_boot(&rig);
    rig_run(&rig, 500);
    rig.port_rate = RIG_BYTES;
    rig_run(&rig, 20);
    CHECK(rig.announces == 1 && rig.announce.session == 0 && rig.telemetries == 1 && rig.device_sequence == 1);
}

static void test_restart(void)
{
    rig_make_armed(&rig);
    rig_drive(&rig, 100, 10, 0, -10);
    rig.configuration.boot = 8;
    rig_boot(&rig);
    CHECK(rig_stands(&rig));
    const unsigned long announces = rig.announces;
    rig_drive(&rig, 100, 10, 0, -10);
    CHECK(rig.announces == announces + 1 && rig.announce.session == 0 && rig.announce.boot == 8);
    CHECK(rig_stands(&rig) && !armed() && rig.telemetry.session == 0 && rig.telemetry.boot == 8);
}

static void test_many_wheels(void)
{
    rig_make(&rig);
    rig.configuration.wheels = 8;
    for (int i = 0; i < 8; ++i) {
        rig.measured[i] = (float)(i + 1);
    }
    rig_boot(&rig);
    rig_hello(&rig, 42);
    struct omnipuck_command command = {42, 0, 0, 200, 0, 0, 0, 8, {0, 0, 0, 0, 0, 0, 0, 0}};
    uint8_t payload[64];
    for (int i = 0; i < 4; ++i) {
        command.sent_ms = rig.clock;
        command.released = i > 0;
        for (int wheel = 0; wheel < 8; ++wheel) {
            command.wheel[wheel] = i > 1 ? (float)(wheel - 4) : 0.0F;
        }
        rig_feed_frame(&rig, 2, 2, payload, host_write_command(payload, &command));
        rig_run(&rig, 20);
    }
    CHECK(rig.telemetry.wheels == 8 && near(rig.telemetry.wheel[7], 8) && near(rig.set[0], -4) && near(rig.set[7], 3));
    CHECK(rig.announce.wheels == 8 && rig.bad_frames == 0);
}

/* Within one step, before the next would put it right. */
static void test_no_gap_of_a_step(void)
{
    rig_make_armed(&rig);
    rig.motor_fault = true;
    ++rig.released;
    rig_command(&rig, 5, 5, 5);
    omnipuck_step(&rig.state);
    CHECK(!rig.state.arming.armed);
    rig.motor_fault = false;
    rig.button = true;
    rig_run(&rig, 1);
    ++rig.cleared;
    rig_command(&rig, 0, 0, 0);
    omnipuck_step(&rig.state);
    CHECK(rig.state.arming.latched);

    /* A life of 0 ms is no step of motion, and not the end of a life. */
    rig_make_armed(&rig);
    rig_drive(&rig, 20, 0, 0, 0);
    rig.life = 0;
    rig_stall(&rig, 5);
    rig_command(&rig, 5, 5, 5);
    omnipuck_step(&rig.state);
    CHECK(rig_stands(&rig) && !rig.state.outlived);
    /* Nor is one dropped because the device is disarmed. */
    rig_make(&rig);
    rig_boot(&rig);
    rig_hello(&rig, 42);
    rig_drive(&rig, 500, 5, 5, 5);
    rig_run(&rig, 300);
    CHECK(!rig_status(&rig, OMNIPUCK_STATUS_OUTLIVED) && rig.telemetry.session == 42);
}

static void test_rate_of_telemetry_with_long_steps(void)
{
    rig_make(&rig);
    rig_boot(&rig);
    for (int i = 0; i < 1000; ++i) {
        omnipuck_step(&rig.state);
        rig_stall(&rig, 7);
    }
    CHECK(rig.telemetries >= 348 && rig.telemetries <= 351);
}

static void test_two_in_one_process(void)
{
    rig_make_armed(&rig);
    rig_make(&other);
    rig_boot(&other);
    rig_hello(&other, 5);
    for (int i = 0; i < 10; ++i) {
        rig_drive(&rig, 20, 10, 0, -10);
        rig_drive(&other, 20, 3, 3, 3);
    }
    CHECK(wheels_near(10, 0, -10) && rig.telemetry.session == 42);
    CHECK(rig_stands(&other) && other.telemetry.session == 5);
}

int main(void)
{
    test_examples_of_the_host();
    test_examples_of_the_device();
    test_examples_on_a_device();
    test_cobs_and_crc();
    test_frames_that_are_dropped();
    test_noise_and_zeros();
    test_sequence();
    test_delay();
    test_wheels();
    test_configuration();
    test_start_and_telemetry_without_a_session();
    test_hello();
    test_new_session_while_driving();
    test_arming();
    test_arming_with_lost_and_late_frames();
    test_emergency_stop_of_the_host();
    test_emergency_button();
    test_late_stop_is_heeded();
    test_caps();
    test_no_jump_after_a_stall();
    test_life();
    test_time_on_the_way();
    test_clocks();
    test_commands_that_are_dropped();
    test_faults();
    test_causes_shorter_than_a_period();
    test_battery_and_temperature();
    test_impacts_and_measured_wheels();
    test_silence();
    test_own_stall();
    test_other_version();
    test_garbage();
    test_cable_pulled();
    test_slow_port();
    test_restart();
    test_many_wheels();
    test_no_gap_of_a_step();
    test_rate_of_telemetry_with_long_steps();
    test_two_in_one_process();
    printf("%lu checks, %lu failures\n", checks, failures);
    return failures == 0 ? 0 : 1;
}
