"""The templates of a report's page."""

import base64
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined

from collplan_study.report.content import as_text, listed, number, with_interval


@cache
def environment() -> Environment:
    """Environment of the templates; values are escaped."""
    made = Environment(
        loader=PackageLoader("collplan_study", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["base64"] = lambda text: base64.b64encode(text.encode()).decode()
    made.filters |= {"interval": with_interval, "number": number, "text": as_text, "listed": listed}
    return made
