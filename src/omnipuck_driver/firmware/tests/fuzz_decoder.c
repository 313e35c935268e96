/* SPDX-License-Identifier: Apache-2.0 */
/* Damaged, forged and random bytes, for the decoder alone and for a whole device.
 *
 * fuzz_decoder N SEED. The judge reads the same bytes with the host's code, which shares nothing with the firmware's. It
 * knows which messages the decoder has to hear, to the byte; and of the device what no rule of the protocol ever allows. It
 * does not know all rules: a device that never moved would pass, so the number of steps in motion is printed, and must not
 * be 0. */
#include "rig.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    INPUT_MAX = 1024,
    REMEMBERED = 64
};

static struct rig rig;
static struct omnipuck_decoder decoder;
static unsigned long input;
static unsigned long steps;
static unsigned long steps_in_motion;
static unsigned long steps_armed;
static unsigned long frames_accepted;
static unsigned long frames_dropped[OMNIPUCK_DROP_REASONS];

static uint64_t random_state;

static uint32_t random_word(void)
{
    random_state ^= random_state >> 12;
    random_state ^= random_state << 25;
    random_state ^= random_state >> 27;
    return (uint32_t)((random_state * 0x2545F4914F6CDD1DULL) >> 32);
}

static uint32_t below(uint32_t limit)
{
    return random_word() % limit;
}

static bool once_in(uint32_t times)
{
    return below(times) == 0;
}

static void must(bool holds, const char *what)
{
    if (!holds) {
        fprintf(stderr, "input %lu: not so: %s\n", input, what);
        abort();
    }
}

/* The judge. */

struct judged_command {
    struct omnipuck_command command;
    uint32_t came;
};

static struct {
    uint8_t bytes[INPUT_MAX * 4];
    size_t length;
    bool numbered;
    uint16_t sequence;

    uint32_t session;
    uint32_t heard;
    float cap;
    bool released_seen[256];
    bool released_since_stop;
    struct judged_command commands[REMEMBERED];
    unsigned long count;
} judge;

static void judge_starts(void)
{
    memset(&judge, 0, sizeof judge);
}

static void judge_session(uint32_t session, float told)
{
    judge.session = session;
    judge.cap = fmaxf(0.0F, fminf(told, rig.configuration.wheel_speed));
    memset(judge.released_seen, 0, sizeof judge.released_seen);
    judge.released_since_stop = false;
    judge.count = 0;
}

static void judge_command(const struct omnipuck_command *command)
{
    if (judge.session == 0 || command->session != judge.session) {
        return;
    }
    if (command->wheels != RIG_WHEELS) {
        return;
    }
    judge.heard = rig.clock;
    if ((command->flags & 3) != 0) {
        judge.released_since_stop = false;
        judge.count = 0;
    } else {
        for (int value = 0; value < 256; ++value) {
            if (judge.released_seen[value] && value != command->released) {
                judge.released_since_stop = true;
            }
        }
        judge.commands[judge.count % REMEMBERED].command = *command;
        judge.commands[judge.count % REMEMBERED].came = rig.clock;
        ++judge.count;
    }
    judge.released_seen[command->released] = true;
}

/* What the decoder has to say of the bytes between two 00. */
static enum omnipuck_heard judge_frame(struct omnipuck_message *message)
{
    struct host_frame frame;
    if (!host_read_frame(judge.bytes, judge.length, &frame)) {
        return OMNIPUCK_HEARD_DROPPED;
    }
    if (frame.version != 2) {
        return OMNIPUCK_HEARD_OTHER_VERSION;
    }
    bool sound = true;
    if (host_read_hello(&frame, &message->of.hello)) {
        message->type = OMNIPUCK_HELLO;
        const float speed = message->of.hello.wheel_speed, acceleration = message->of.hello.wheel_acceleration;
        sound = isfinite(speed) && isfinite(acceleration) && speed > 0 && acceleration > 0;
    } else if (host_read_command(&frame, &message->of.command)) {
        message->type = OMNIPUCK_COMMAND;
        sound = message->of.command.wheels <= 8;
        for (size_t i = 0; i < message->of.command.wheels; ++i) {
            float value;
            memcpy(&value, frame.payload + 16 + 4 * i, sizeof value);
            sound = sound && isfinite(value);
        }
    } else {
        return OMNIPUCK_HEARD_DROPPED;
    }
    const bool later = (int16_t)(uint16_t)(frame.sequence - judge.sequence) > 0;
    if (!sound || (message->type == OMNIPUCK_COMMAND && judge.numbered && !later)) {
        return OMNIPUCK_HEARD_DROPPED;
    }
    judge.numbered = true;
    judge.sequence = frame.sequence;
    return OMNIPUCK_HEARD_MESSAGE;
}

static enum omnipuck_heard judge_byte(uint8_t byte, struct omnipuck_message *message)
{
    if (byte != 0) {
        must(judge.length < sizeof judge.bytes, "the judge has room");
        judge.bytes[judge.length++] = byte;
        return OMNIPUCK_HEARD_NOTHING;
    }
    const enum omnipuck_heard heard = judge.length == 0 ? OMNIPUCK_HEARD_NOTHING : judge_frame(message);
    judge.length = 0;
    if (heard == OMNIPUCK_HEARD_MESSAGE && message->type == OMNIPUCK_COMMAND) {
        judge_command(&message->of.command);
    } else if (heard == OMNIPUCK_HEARD_MESSAGE) {
        if (message->of.hello.session != judge.session) {
            judge_session(message->of.hello.session, message->of.hello.wheel_speed);
        }
        judge.heard = rig.clock;
    }
    return heard;
}

static bool same_float(float a, float b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

static bool same_message(const struct omnipuck_message *a, const struct omnipuck_message *b)
{
    if (a->type != b->type) {
        return false;
    }
    if (a->type == OMNIPUCK_HELLO) {
        return a->of.hello.session == b->of.hello.session
               && same_float(a->of.hello.wheel_speed, b->of.hello.wheel_speed)
               && same_float(a->of.hello.wheel_acceleration, b->of.hello.wheel_acceleration);
    }
    const struct omnipuck_command *c = &a->of.command;
    const struct omnipuck_command *d = &b->of.command;
    bool same = c->session == d->session && c->sent_ms == d->sent_ms && c->age_ms == d->age_ms
                && c->life_ms == d->life_ms && c->flags == d->flags && c->cleared == d->cleared
                && c->released == d->released && c->wheels == d->wheels;
    for (size_t i = 0; same && i < c->wheels && i < OMNIPUCK_WHEELS_MAX; ++i) {
        same = same_float(c->wheel[i], d->wheel[i]);
    }
    return same;
}

/* A wheel on its way from 0 to what a command asks for, or slowed by the cap. */
static bool allows(const struct judged_command *one)
{
    const uint32_t life = one->command.life_ms < 500 ? one->command.life_ms : 500;
    if (rig.clock - one->came >= life) {
        return false;
    }
    for (size_t i = 0; i < RIG_WHEELS; ++i) {
        const float wanted = one->command.wheel[i];
        const bool same_way = rig.set[i] * wanted >= 0.0F || fabsf(wanted) > 1e30F;
        if (fabsf(rig.set[i]) > fabsf(wanted) * 1.00001F || !same_way) {
            return false;
        }
    }
    return true;
}

static void judge_step(void)
{
    ++steps;
    if (rig.button || rig.motor_fault || rig.too_hot) {
        judge.released_since_stop = false;
        judge.count = 0;
    }
    if (judge.session != 0 && rig.clock - judge.heard >= 1000) {
        judge_session(0, 0.0F);
    }
    for (size_t i = 0; i < RIG_WHEELS; ++i) {
        must(isfinite(rig.set[i]), "a wheel's speed is finite");
    }
    steps_armed += rig.state.arming.armed;
    must(rig.state.session == judge.session, "the session is the judge's");
    must(!rig.state.arming.armed || judge.released_since_stop, "armed by a change of released since the last stop");
    must(!(rig.state.arming.armed && rig.state.arming.latched), "not armed while latched");
    must(rig.state.arming.latched || !rig.button, "a pressed button latches");
    if (!rig_stands(&rig)) {
        ++steps_in_motion;
        must(rig.state.arming.armed, "moves armed only");
        must(rig_fastest(&rig) <= judge.cap, "no wheel beyond the cap");
        bool allowed = false;
        for (unsigned long i = 0; i < judge.count && i < REMEMBERED; ++i) {
            allowed = allowed || allows(&judge.commands[i]);
        }
        must(allowed, "moves as a command allows whose life lasts");
    }
    must(rig.bad_frames == 0, "the device sends whole frames only");
    must(rig.gaps == 0, "the device's numbers have no gaps");
    for (size_t i = 0; i < rig.telemetry.wheels; ++i) {
        must(isfinite(rig.telemetry.wheel[i]), "telemetry is finite");
    }
}

/* The inputs. */

static size_t write_hello(uint8_t *frame, uint32_t session)
{
    uint8_t payload[16];
    const struct omnipuck_hello hello = {session, once_in(8) ? (float)below(200) - 20.0F : 70.5F,
                                         once_in(8) ? (float)below(3000) : 500.0F};
    rig.session = session;
    return host_write_frame(frame, 2, 1, rig.sequence++, payload, host_write_hello(payload, &hello));
}

static size_t write_command(uint8_t *frame)
{
    uint8_t payload[64];
    rig.cleared = (uint8_t)(rig.cleared + once_in(40));
    rig.released = (uint8_t)(rig.released + once_in(40));
    struct omnipuck_command command = {
        rig.session, rig.clock + rig.host_ahead, 0, 200, 0, rig.cleared, rig.released, RIG_WHEELS,
        {0, 0, 0, 0, 0, 0, 0, 0}};
    if (once_in(60)) {
        command.flags = (uint8_t)below(256);
    }
    if (once_in(10)) {
        command.life_ms = (uint16_t)below(1000);
    }
    if (!once_in(3)) {
        for (size_t i = 0; i < RIG_WHEELS; ++i) {
            command.wheel[i] = ((float)below(2000) - 1000.0F) * (once_in(10) ? 1e30F : 0.05F);
        }
    }
    if (once_in(100)) {
        command.wheel[below(RIG_WHEELS)] = once_in(2) ? INFINITY : -NAN;
    }
    return host_write_frame(frame, 2, 2, rig.sequence++, payload, host_write_command(payload, &command));
}

/* Damage a line does: bits, bytes gone, bytes come. */
static size_t damage(uint8_t *bytes, size_t length)
{
    for (uint32_t times = 1 + below(4); times > 0 && length > 1; --times) {
        const size_t at = below((uint32_t)length);
        switch (below(4)) {
        case 0:
            bytes[at] = (uint8_t)(bytes[at] ^ (1U << below(8)));
            break;
        case 1:
            bytes[at] = (uint8_t)below(256);
            break;
        case 2:
            memmove(bytes + at, bytes + at + 1, length - at - 1);
            --length;
            break;
        default:
            memmove(bytes + at + 1, bytes + at, length - at);
            bytes[at] = once_in(2) ? 0 : (uint8_t)below(256);
            ++length;
            break;
        }
    }
    return length;
}

/* What no line does: another body with a crc that fits. */
static size_t forge(uint8_t *bytes, size_t length)
{
    struct host_frame frame;
    if (!host_read_frame(bytes + 1, length - 2, &frame)) {
        return length;
    }
    uint8_t body[HOST_FRAME_MAX];
    memcpy(body, frame.body, frame.length);
    size_t checked = frame.length - 4;
    for (uint32_t times = 1 + below(3); times > 0; --times) {
        if (once_in(6)) {
            checked = below(150);
            for (size_t i = frame.length - 4; i < checked; ++i) {
                body[i] = (uint8_t)below(256);
            }
        } else if (checked > 0) {
            /* The version seldom, or nothing else would ever be looked at. */
            const size_t at = once_in(8) ? 0 : below((uint32_t)checked);
            body[at] = (uint8_t)(once_in(2) ? below(256) : body[at] ^ (1U << below(8)));
        }
    }
    const uint32_t crc = host_crc(body, checked);
    for (size_t i = 0; i < 4; ++i) {
        body[checked + i] = (uint8_t)(crc >> (8 * i) & 255U);
    }
    bytes[0] = 0;
    const size_t stuffed = host_stuff(body, checked + 4, bytes + 1);
    bytes[1 + stuffed] = 0;
    return stuffed + 2;
}

static size_t write_random(uint8_t *bytes)
{
    const size_t length = below(once_in(4) ? 400 : 40);
    const uint32_t kinds = once_in(2) ? 256 : 1 + below(8);
    for (size_t i = 0; i < length; ++i) {
        bytes[i] = (uint8_t)below(kinds);
    }
    return length;
}

static size_t write_input(uint8_t *bytes)
{
    const uint32_t kind = below(100);
    if (kind < 10) {
        return write_random(bytes);
    }
    const uint32_t session = once_in(4) ? below(4) : rig.session;
    const size_t length = once_in(50) ? write_hello(bytes, session) : write_command(bytes);
    if (kind < 25) {
        return damage(bytes, length);
    }
    if (kind < 40) {
        return forge(bytes, length);
    }
    if (kind < 42) {
        return below((uint32_t)length);
    }
    if (kind < 44) {
        memcpy(bytes + length, bytes, length);
        return 2 * length;
    }
    return length;
}

static void feed(const uint8_t *bytes, size_t length)
{
    for (size_t i = 0; i < length; ++i) {
        struct omnipuck_message heard;
        struct omnipuck_message wanted;
        const enum omnipuck_heard want = judge_byte(bytes[i], &wanted);
        must(omnipuck_decoder_feed(&decoder, bytes[i], &heard) == want, "the decoder hears what the judge does");
        must(want != OMNIPUCK_HEARD_MESSAGE || same_message(&heard, &wanted), "the message is the judge's");
    }
    rig_feed(&rig, bytes, length);
    do {
        rig_run(&rig, 0);
    } while (rig.to_device_length > 0);
    judge_step();
    must(rig.state.decoder.accepted == decoder.accepted && rig.state.decoder.dropped == decoder.dropped,
         "the device counts as the decoder alone does");
}

/* Whatever came before: after a 00 a good frame is heard. */
static void check_next_frame(void)
{
    struct omnipuck_decoder copy = decoder;
    struct omnipuck_message message;
    /* This 00 may be the end of a good frame, which takes a number. */
    omnipuck_decoder_feed(&copy, 0, &message);
    uint8_t frame[HOST_FRAME_MAX];
    uint8_t payload[64];
    struct omnipuck_command command = {1, 2, 3, 4, 0, 6, 7, RIG_WHEELS, {1, 2, 3, 0, 0, 0, 0, 0}};
    const size_t length = host_write_frame(frame, 2, 2, (uint16_t)(copy.sequence + 1), payload,
                                           host_write_command(payload, &command));
    enum omnipuck_heard heard = OMNIPUCK_HEARD_NOTHING;
    for (size_t i = 0; i < length; ++i) {
        heard = omnipuck_decoder_feed(&copy, frame[i], &message);
    }
    must(heard == OMNIPUCK_HEARD_MESSAGE && message.of.command.released == 7, "a good frame after a 00 is heard");
}

static void restart(void)
{
    for (int reason = 0; reason < OMNIPUCK_DROP_REASONS; ++reason) {
        frames_dropped[reason] += decoder.drops[reason];
    }
    frames_accepted += decoder.accepted;
    rig_make(&rig);
    rig.clock = random_word();
    rig.host_ahead = random_word();
    rig.sequence = (uint16_t)random_word();
    rig.port_rate = once_in(2) ? 1 + below(20) : RIG_BYTES;
    rig.measured[1] = once_in(4) ? NAN : 1.0F;
    rig_boot(&rig);
    omnipuck_decoder_start(&decoder);
    judge_starts();
    uint8_t bytes[INPUT_MAX];
    feed(bytes, write_hello(bytes, 1 + below(3)));
}

static void let_time_pass(void)
{
    rig.button = once_in(rig.button ? 4 : 200) ? !rig.button : rig.button;
    rig.motor_fault = once_in(rig.motor_fault ? 4 : 200) ? !rig.motor_fault : rig.motor_fault;
    rig.too_hot = once_in(rig.too_hot ? 4 : 200) ? !rig.too_hot : rig.too_hot;
    rig.impacts_waiting += once_in(20);
    if (once_in(100)) {
        rig_stall(&rig, below(3) == 0 ? below(2500) : below(300));
        return;
    }
    const uint32_t pause = once_in(50) ? below(700) : below(6);
    for (uint32_t i = 0; i < pause; ++i) {
        ++rig.clock;
        rig.port_room = rig.port_rate;
        omnipuck_step(&rig.state);
        judge_step();
    }
}

int main(int count, char **arguments)
{
    const unsigned long inputs = count > 1 ? strtoul(arguments[1], NULL, 10) : 100000;
    const unsigned long seed = count > 2 ? strtoul(arguments[2], NULL, 10) : 1;
    random_state = seed * 0x9E3779B97F4A7C15ULL + 1;
    omnipuck_decoder_start(&decoder);
    for (input = 0; input < inputs; ++input) {
        uint8_t bytes[INPUT_MAX];
        if (input % 1000 == 0) {
            restart();
        }
        let_time_pass();
        /* The judge keeps all since the last 00; random bytes may have none for long. */
        if (judge.length > INPUT_MAX) {
            const uint8_t zero = 0;
            feed(&zero, 1);
        }
        feed(bytes, write_input(bytes));
        check_next_frame();
    }
    input = inputs;
    restart();
    printf("%lu inputs of seed %lu: %lu frames accepted, dropped", inputs, seed, frames_accepted);
    static const char *const names[OMNIPUCK_DROP_REASONS] = {"",     "too long", "COBS",       "too short", "crc", "version",
                                                             "type", "length",   "content", "repetition"};
    for (int reason = 1; reason < OMNIPUCK_DROP_REASONS; ++reason) {
        printf("%s %lu %s", reason == 1 ? "" : ",", frames_dropped[reason], names[reason]);
    }
    printf("; %lu steps, %lu armed, %lu in motion\n", steps, steps_armed, steps_in_motion);
    must(inputs < 10000 || steps_in_motion > 0, "something moved");
    return 0;
}
