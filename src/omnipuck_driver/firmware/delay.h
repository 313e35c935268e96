/* SPDX-License-Identifier: Apache-2.0 */
/* How long a command was on its way, beyond the fastest one of its session. Neither clock is set by the other, so only
 * differences of (own clock - sent) mean anything. All times in ms, all clocks modulo 2^32. */
#ifndef OMNIPUCK_DELAY_H
#define OMNIPUCK_DELAY_H

#include <stdbool.h>
#include <stdint.h>

enum {
    /* A delay further than this beyond the smallest is a clock that was set, or a stall as long. */
    OMNIPUCK_CLOCK_SET_BEYOND_MS = 5000,
    /* The smallest delay rises by 1 ms in this time: the clocks of host and device drift. */
    OMNIPUCK_DRIFT_PERIOD_MS = 1000
};

struct omnipuck_delay {
    bool measured;
    uint32_t smallest;    /* own clock - sent */
    uint32_t since_raise; /* ms */
};

void omnipuck_delay_forget(struct omnipuck_delay *delay);

void omnipuck_delay_pass(struct omnipuck_delay *delay, uint32_t elapsed);

/* False if a clock was set; else says in *excess how much longer this command was on its way than the fastest. */
bool omnipuck_delay_measure(struct omnipuck_delay *delay, uint32_t sent, uint32_t now, uint32_t *excess);

#endif
