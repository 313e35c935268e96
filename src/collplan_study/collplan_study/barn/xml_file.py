"""Reads untrusted XML files: hostile or huge ones are refused, and every element keeps its line number."""

import gzip
import zlib
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, TreeBuilder
from xml.sax import SAXException
from xml.sax.handler import ContentHandler

from defusedxml import DefusedXmlException
from defusedxml.sax import parseString

from collplan_core.worlds import WorldError

LARGEST = 16 * 2**20
"""Largest file, both on the disk and unpacked [bytes]; a world of 345 cylinders has 0.7 million."""
MOST_ELEMENTS = 300_000
DEEPEST = 100

# has a space, so that no attribute of a file has this name
_LINE = "line number"
GZIP = b"\x1f\x8b"
"""First bytes of a gzip file."""


def read_xml(path: Path) -> Element:
    """Reads the root element of a file, gzip-compressed or not; its name does not matter.

    Raises:
        WorldError: the file does not exist, is too large, is not XML, or has a document type declaration, which could
            define entities and refer to other files. The message names the file and, if known, the line.
    """
    handler = _Tree()
    try:
        parseString(_content(path), handler, forbid_dtd=True)
    except DefusedXmlException:
        raise WorldError(f"{handler.place(path)}: a document type or entity declaration, expected none") from None
    except _LimitExceeded as error:
        raise WorldError(f"{handler.place(path)}: {error}") from None
    except (SAXException, ValueError, LookupError) as error:
        raise WorldError(f"{handler.place(path)}: not XML ({_reason(error)})") from None
    return handler.root


def line_of(element: Element) -> int:
    """Line at which an element of `read_xml` begins in its file, from 1."""
    return int(element.attrib[_LINE])


def attributes(element: Element) -> dict[str, str]:
    """Attributes that the file gives an element of `read_xml`."""
    return {name: value for name, value in element.attrib.items() if name != _LINE}


class _LimitExceeded(ValueError):
    pass


class _Tree(ContentHandler):
    """Builds the tree; counts elements and their depth."""

    def __init__(self) -> None:
        super().__init__()
        self._builder = TreeBuilder()
        self._locator: Any = None
        self._depth = self._count = 0
        self.root = Element("")

    def setDocumentLocator(self, locator: Any) -> None:  # noqa: N802
        self._locator = locator

    def startElement(self, name: str, attrs: Any) -> None:  # noqa: N802
        self._depth += 1
        self._count += 1
        if self._depth > DEEPEST:
            raise _LimitExceeded(f"<{name:.40}> is nested deeper than {DEEPEST} elements")
        if self._count > MOST_ELEMENTS:
            raise _LimitExceeded(f"more than {MOST_ELEMENTS} elements")
        self._builder.start(name, {**attrs, _LINE: str(self._line)})

    def endElement(self, name: str) -> None:  # noqa: N802
        self._depth -= 1
        self._builder.end(name)

    def characters(self, content: str) -> None:
        self._builder.data(content)

    def endDocument(self) -> None:  # noqa: N802
        self.root = self._builder.close()

    def place(self, path: Path) -> str:
        """File and current line as path:line."""
        return f"{path}:{self._line}" if self._locator else str(path)

    @property
    def _line(self) -> int:
        return int(self._locator.getLineNumber())


def _content(path: Path) -> bytes:
    if not path.exists():
        raise WorldError(f"{path}: no such file")
    # a pipe or a device may never end
    if not path.is_file():
        raise WorldError(f"{path}: not a file")
    try:
        with path.open("rb") as file:
            content = _bounded(path, file)
        if content[:2] != GZIP:
            return content
        with gzip.open(path) as file:
            return _bounded(path, file, " unpacked")
    except (OSError, EOFError, zlib.error) as error:
        raise WorldError(f"{path}: cannot be read ({_reason(error)})") from None


def _bounded(path: Path, file: Any, how: str = "") -> bytes:
    content: bytes = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise WorldError(f"{path}: larger than {LARGEST // 2**20} MiB{how}")
    return content


def _reason(error: Exception) -> str:
    if isinstance(error, SAXException):
        return error.getMessage()
    return " ".join(str(getattr(error, "strerror", None) or error).split())
