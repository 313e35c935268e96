/* What the device says: Announce when greeted, telemetry at a steady rate.
 *
 * Announces go first, and wait for the port. Telemetry does not wait, for the next one says more: one that finds the port
 * taken is left out whole. */
#ifndef OMNIPUCK_REPORT_H
#define OMNIPUCK_REPORT_H

#include "firmware.h"

/* Sends what is due. */
void omnipuck_report(struct omnipuck_state *state);

#endif
