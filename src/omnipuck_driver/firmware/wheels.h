/* SPDX-License-Identifier: Apache-2.0 */
/* The caps of the wheels' speed [rad/s] and acceleration [rad/s^2]. "All alike": one factor for all wheels, so that the
 * robot goes slower on the way it was told, and not another way. */
#ifndef OMNIPUCK_WHEELS_H
#define OMNIPUCK_WHEELS_H

#include <stddef.h>

/* Slows speeds so that none exceeds cap, which is not negative. */
void omnipuck_wheels_cap(float *speeds, size_t wheels, float cap);

/* Brings speeds toward wanted, as far as `elapsed` seconds allow. A wheel that is to turn slower does so at once; one that
 * is to turn the other way stands at once, and turns faster from there. */
void omnipuck_wheels_ramp(float *speeds, const float *wanted, size_t wheels, float acceleration, float elapsed);

#endif
