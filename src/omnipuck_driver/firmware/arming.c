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
    /* As it was before this command: the one that ends the emergency stop leaves the device disarmed. */
    const bool was_latched = arming->latched;
    if (clears && !button_pressed && (flags & OMNIPUCK_FLAG_EMERGENCY_STOP) == 0) {
        arming->latched = false;
    }
    /* Of a flag this version does not know it is not known that the robot may move. */
    if (releases && flags == 0 && !was_latched && !fault) {
        arming->armed = true;
    }
}
