/* SPDX-License-Identifier: Apache-2.0 */
/* What the device says: Announce when greeted, telemetry at a steady rate.
 *
 * Announces go first. Telemetry is written when the port is free for it, so it says what is true then; when the port was
 * taken for more than a period, or takes nothing of it, the telemetry of that period is left out. */
#ifndef OMNIPUCK_REPORT_H
#define OMNIPUCK_REPORT_H

#include "firmware.h"

/* Sends what is due. */
void omnipuck_report(struct omnipuck_state *state);

#endif
