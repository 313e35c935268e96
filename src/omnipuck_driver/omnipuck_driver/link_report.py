"""Figures of the serial link for diagnostics."""

from omnipuck_driver.codec import REASONS
from omnipuck_driver.messages import GIVES_TEMPERATURE, NO_TEMPERATURE, SENSES_IMPACTS
from omnipuck_driver.serial_link import SerialLink


class LinkReport:
    """Counts of a link since the start, and the quality of its input since the last call."""

    def __init__(self, link: SerialLink) -> None:
        self._link = link
        self._before = (0, 0)

    def values(self) -> dict[str, object]:
        """Figures by name; `quality_in` is the share of frames that came whole since the last call, -1 without any."""
        decoder = self._link.session.decoder
        dropped = {f"dropped_{reason}": decoder.dropped[reason] for reason in REASONS}
        return {
            "quality_in": self._quality(),
            "frames_in": decoder.accepted,
            "frames_lost": decoder.lost,
            **dropped,
            "frames_out": self._link.sent,
            "frames_unsent": self._link.unsent,
            "sessions": self._link.session.begun,
            **self._firmware_values(),
        }

    def _quality(self) -> float:
        decoder = self._link.session.decoder
        newest = decoder.accepted, decoder.lost
        came, lost = (new - old for new, old in zip(newest, self._before, strict=True))
        self._before = newest
        return came / (came + lost) if came + lost else -1.0

    def _firmware_values(self) -> dict[str, object]:
        session = self._link.session
        announced, telemetry = session.announced, session.telemetry
        if announced is None or telemetry is None:
            return {}
        values: dict[str, object] = {
            "firmware": announced.firmware,
            "impact_sensing": "yes" if announced.capabilities & SENSES_IMPACTS else "no",
            "armed": "yes" if session.armed else "no",
            "battery_v": telemetry.battery * 1e-3,
            "firmware_frames_in": telemetry.accepted,
            "firmware_frames_dropped": telemetry.dropped,
            "wheel_speeds": " ".join(f"{speed:.2f}" for speed in telemetry.wheels),
        }
        if session.latency is not None:
            values["latency_s"] = session.latency
        if announced.capabilities & GIVES_TEMPERATURE and telemetry.temperature != NO_TEMPERATURE:
            values["temperature_deg_c"] = telemetry.temperature * 0.1
        return values
