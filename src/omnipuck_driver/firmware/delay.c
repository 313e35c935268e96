/* SPDX-License-Identifier: Apache-2.0 */
#include "delay.h"

static void measure_anew(struct omnipuck_delay *delay, uint32_t smallest)
{
    delay->measured = true;
    delay->smallest = smallest;
    delay->since_raise = 0;
}

void omnipuck_delay_forget(struct omnipuck_delay *delay)
{
    measure_anew(delay, 0);
    delay->measured = false;
}

void omnipuck_delay_pass(struct omnipuck_delay *delay, uint32_t elapsed)
{
    /* Apart, because their sum may be more than 2^32. */
    delay->smallest += elapsed / OMNIPUCK_DRIFT_PERIOD_MS;
    delay->since_raise += elapsed % OMNIPUCK_DRIFT_PERIOD_MS;
    if (delay->since_raise >= OMNIPUCK_DRIFT_PERIOD_MS) {
        delay->since_raise -= OMNIPUCK_DRIFT_PERIOD_MS;
        ++delay->smallest;
    }
}

bool omnipuck_delay_measure(struct omnipuck_delay *delay, uint32_t sent, uint32_t now, uint32_t *excess)
{
    const uint32_t own = now - sent;
    /* 0 to 2^31 - 1: longer than the fastest. From 2^31 on it is a negative number, modulo 2^32: faster than it. */
    const uint32_t beyond = own - delay->smallest;
    *excess = 0;
    if (!delay->measured || beyond == 0 || beyond >= 0x80000000U) {
        measure_anew(delay, own);
        return true;
    }
    if (beyond > OMNIPUCK_CLOCK_SET_BEYOND_MS) {
        measure_anew(delay, own);
        return false;
    }
    *excess = beyond;
    return true;
}
