"""Telemetry of a firmware at rest that takes commands, for tests that change one thing of it."""

from omnipuck_driver.messages import NEVER, NO_TEMPERATURE, Telemetry

TELEMETRY = Telemetry(
    session=7,
    boot=3,
    time=5000,
    status=0,
    battery=7400,
    temperature=NO_TEMPERATURE,
    echo=1000,
    echo_delay=5,
    command_age=NEVER,
    accepted=3,
    dropped=0,
    impacts=0,
    impact_age=NEVER,
    impact=(0.0, 0.0),
    cleared=0,
    released=0,
    wheels=(0.0, 0.0, 0.0),
)
