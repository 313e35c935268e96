/* SPDX-License-Identifier: Apache-2.0 */
#include "arming.h"

#include "messages.h"

void omnipuck_arming_start(struct omnipuck_arming *arming)
{
    arming->latched = false;
    omnipuck_arming_new_session(arming);
}

void omnipuck_arming_new_session(struct omnipuck_arming *arming)
{
    arming->armed = false;
    arming->counted = false;
    arming->cleared = 0;
    arming->released = 0;
}

void omnipuck_arming_disarm(struct omnipuck_arming *arming)
{
    arming->armed = false;
}

void omnipuck_arming_emergency_stop(struct omnipuck_arming *arming)
{
    arming->latched = true;
    arming->armed = false;
}

void omnipuck_arming_flags(struct omnipuck_arming *arming, uint8_t flags)
{
    if ((flags & OMNIPUCK_FLAG_EMERGENCY_STOP) != 0) {
        omnipuck_arming_emergency_stop(arming);
    }
    if ((flags & OMNIPUCK_FLAG_HOLD) != 0) {
        omnipuck_arming_disarm(arming);
    }
}

void omnipuck_arming_command(struct omnipuck_arming *arming, uint8_t flags, uint8_t cleared, uint8_t released,
                             bool button_pressed, bool fault)
{
    const bool clears = arming->counted && cleared != arming->cleared;
    const bool releases = arming->counted && released != arming->released;
    /* A change that may not act now is noted all the same: it is used up, and cannot act when the obstacle is gone. */
    arming->counted = true;
    arming->cleared = cleared;
    arming->released = released;

    omnipuck_arming_flags(arming, flags);
    if (clears && !button_pressed && (flags & OMNIPUCK_FLAG_EMERGENCY_STOP) == 0) {
        arming->latched = false;
    }
    /* Cleared first: of a command that changes both counts the one before it was lost, and the host has seen to the order. */
    const bool stops = (flags & (OMNIPUCK_FLAG_EMERGENCY_STOP | OMNIPUCK_FLAG_HOLD)) != 0;
    if (releases && !stops && !arming->latched && !fault) {
        arming->armed = true;
    }
}
