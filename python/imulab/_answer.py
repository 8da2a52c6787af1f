"""What every answer has: the command's JSON as data, its table as text, its page, and what is missing."""

from __future__ import annotations

import html
import json
from functools import cached_property
from typing import Any

from . import _imulab
from ._imulab import Unsupported
from ._text import PathLike, path


class Answer:
    """An answer. `data` is the JSON that the command prints; print(answer) is its table.

    `shortcomings` says why it is not what was asked for; empty: it is. The command ends with exit code 1 there; `expect_supported()` raises.
    """

    _answer: _imulab.Outcome | _imulab.Calibration

    @property
    def json(self) -> str:
        """What the command prints with --json."""
        return self._answer.json

    @cached_property
    def data(self) -> dict[str, Any]:
        """The same as dicts and lists; null is None."""
        data: dict[str, Any] = json.loads(self.json)
        return data

    @property
    def shortcomings(self) -> str:
        """Why the answer is not what was asked for: not converged, not determined, requirements not reached. Empty: it is."""
        return self._answer.shortcomings

    @property
    def warnings(self) -> list[str]:
        """What was found in the data, and what it means for the result."""
        return self._answer.warnings

    def expect_supported(self) -> None:
        """Raises Unsupported with the shortcomings where there are any."""
        if self.shortcomings:
            raise Unsupported(self.shortcomings)

    def save(self, file: PathLike) -> None:
        """Writes the JSON, whole or not at all."""
        _imulab.write_whole(path("file", file), self.json)

    def report(self, file: PathLike) -> None:
        """Writes the page: one HTML file, self-contained. Of a calibration with pictures from the recordings where it was just made from them."""
        _imulab.write_whole(path("file", file), self._answer.page())

    def __str__(self) -> str:
        return self._answer.text

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"
