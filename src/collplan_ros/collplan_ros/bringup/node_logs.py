"""The output of each node, one file each."""

from pathlib import Path

from rcl_interfaces.msg import Log

SHOWN = 10
"""Lines of a node's output that are printed when it has ended."""
LEVELS = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}


class NodeLogs:
    """The files NODE.log in a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def path(self, name: str) -> Path:
        """The file of a node."""
        return self._folder / f"{name}.log"

    def append(self, name: str, text: str) -> None:
        """Adds lines to the file of a node."""
        with self.path(name).open("a", encoding="utf-8") as file:
            file.write(text)

    def take(self, message: Log) -> None:
        """Adds a message of /rosout to the file of its node, in the form of ROS."""
        level, at = LEVELS.get(message.level, message.level), message.stamp
        line = f"[{level}] [{at.sec}.{at.nanosec:09d}] [{message.name}]: {message.msg}\n"
        self.append(message.name.rpartition(".")[2], line)

    def last_lines(self, name: str) -> str:
        """The last lines of a node's output, as a message."""
        path = self.path(name)
        lines = path.read_text(errors="replace").splitlines()[-SHOWN:] if path.exists() else []
        return f"last lines of {name}:\n" + "\n".join(f"  {line}" for line in lines or ["(none)"])
