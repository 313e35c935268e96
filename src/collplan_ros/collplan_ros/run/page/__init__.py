"""run.html and beside: runs that play on the live page, in one file that needs nothing but a browser."""

from collplan_ros.run.page.run_page import write_run_page

__all__ = ["write_run_page"]
