/* SPDX-License-Identifier: Apache-2.0 */
#include "wheels.h"

#include <stdbool.h>

static float magnitude(float value)
{
    return value < 0.0F ? -value : value;
}

void omnipuck_wheels_cap(float *speeds, size_t wheels, float cap)
{
    float fastest = 0.0F;
    for (size_t i = 0; i < wheels; ++i) {
        if (magnitude(speeds[i]) > fastest) {
            fastest = magnitude(speeds[i]);
        }
    }
    if (fastest <= cap) {
        return;
    }
    const float factor = cap / fastest;
    for (size_t i = 0; i < wheels; ++i) {
        speeds[i] *= factor;
        /* Rounding may leave the product a little above. */
        if (speeds[i] > cap) {
            speeds[i] = cap;
        } else if (speeds[i] < -cap) {
            speeds[i] = -cap;
        }
    }
}

/* What a wheel does at once: all of it but turning faster. */
static float at_once(float speed, float wanted)
{
    const bool same_way = (speed > 0.0F && wanted > 0.0F) || (speed < 0.0F && wanted < 0.0F);
    if (!same_way) {
        return 0.0F;
    }
    return magnitude(wanted) < magnitude(speed) ? wanted : speed;
}

void omnipuck_wheels_ramp(float *speeds, const float *wanted, size_t wheels, float acceleration, float elapsed)
{
    float most = 0.0F;
    for (size_t i = 0; i < wheels; ++i) {
        speeds[i] = at_once(speeds[i], wanted[i]);
        const float missing = magnitude(wanted[i] - speeds[i]);
        if (missing > most) {
            most = missing;
        }
    }
    const float step = acceleration * elapsed;
    if (most <= step) {
        for (size_t i = 0; i < wheels; ++i) {
            speeds[i] = wanted[i];
        }
        return;
    }
    for (size_t i = 0; i < wheels; ++i) {
        speeds[i] += (wanted[i] - speeds[i]) * (step / most);
    }
}
