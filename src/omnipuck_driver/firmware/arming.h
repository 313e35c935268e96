/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the wheels may turn: armed or not, and the latch of the emergency stop. Both end a stop by the change of a count
 * that only a person's act changes, so that no program and no lost frame can do it. */
#ifndef OMNIPUCK_ARMING_H
#define OMNIPUCK_ARMING_H

#include <stdbool.h>
#include <stdint.h>

struct omnipuck_arming {
    bool armed;
    bool latched;
    bool counted; /* a command of this session has set the counts */
    uint8_t cleared;
    uint8_t released;
};

void omnipuck_arming_start(struct omnipuck_arming *arming);

/* A session begins or is forgotten: disarms and forgets the counts. A latched stop stays. */
void omnipuck_arming_new_session(struct omnipuck_arming *arming);

void omnipuck_arming_disarm(struct omnipuck_arming *arming);

/* Latches and disarms. */
void omnipuck_arming_emergency_stop(struct omnipuck_arming *arming);

/* What the flags alone say: they only ever stop, so they are also heeded in a command that came too late for its wheels. */
void omnipuck_arming_flags(struct omnipuck_arming *arming, uint8_t flags);

/* Flags and counts of a command that came in time. */
void omnipuck_arming_command(struct omnipuck_arming *arming, uint8_t flags, uint8_t cleared, uint8_t released,
                             bool button_pressed, bool fault);

#endif
