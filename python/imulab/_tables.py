"""Results as HTML for notebooks. Everything is escaped: names come from files."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence
from typing import Any

_COLORS = {"met": "#007355", "good": "#007355", "not met": "#a03c00", "doubtful": "#a03c00"}


def number(value: Any) -> str:
    """With five digits; a dash where there is none."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "\N{EN DASH}"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def measured(value: float, sigma: float) -> tuple[str, str]:
    """A value and its standard uncertainty, both to two digits of the latter."""
    if not sigma > 0 or math.isinf(sigma):
        return number(value), number(sigma)
    places = 1 - math.floor(math.log10(sigma))
    return f"{round(value, places):.{max(0, places)}f}", f"{round(sigma, places):.{max(0, places)}f}"


def table(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Numbers are aligned right."""

    def cell(value: Any) -> str:
        side = "right" if not isinstance(value, str) or value.lstrip("-")[:1].isdigit() else "left"
        return f'<td style="text-align:{side}">{html.escape(number(value))}</td>'

    top = "".join(f'<th style="text-align:left">{html.escape(name)}</th>' for name in head)
    body = "".join("<tr>" + "".join(cell(value) for value in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def lines(texts: Iterable[str]) -> str:
    """A list; empty without texts."""
    items = "".join(f"<li>{html.escape(text)}</li>" for text in texts)
    return f"<ul>{items}</ul>" if items else ""


def headline(verdict: str, text: str) -> str:
    """The one sentence of a result, with its verdict where there is one."""
    shown = f'<b style="color:{_COLORS.get(verdict, "inherit")}">{html.escape(verdict)}</b> ' if verdict else ""
    return f"<p>{shown}{html.escape(text)}</p>"
