"""Small things that several parts share: file names, TOML, warnings, optional packages."""

from __future__ import annotations

import importlib
import inspect
import os
import sys
import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from ._imulab import Error, in_keywords, keywords

PathLike = str | os.PathLike[str]
_Function = TypeVar("_Function", bound=Callable[..., Any])
_KEYWORDS = keywords()


class DataWarning(UserWarning):
    """A finding in the data, and its consequence for the result."""


def warn(texts: Iterable[str]) -> None:
    """Each as a DataWarning at the place in the user's code that called."""
    level, frame = 2, sys._getframe(1)
    while frame.f_back is not None and str(frame.f_globals.get("__name__", "")).startswith("imulab."):
        frame, level = frame.f_back, level + 1
    for text in texts:
        warnings.warn(in_keywords(text), DataWarning, stacklevel=level)


def path(name: str, value: Any) -> str:
    """A file's name. Raises TypeError for what is none."""
    if not isinstance(value, (str, os.PathLike)):
        raise TypeError(f"{name}: expected a path, got {type(value).__name__}")
    text = os.fspath(value)
    if not isinstance(text, str):
        raise TypeError(f"{name}: expected a path of text, got bytes")
    if "\0" in text:
        raise Error(f"{name}: has a NUL character; expected a path")
    return text


def optional_package(name: str, purpose: str) -> Any:
    """pandas or matplotlib, which are used where they are. Raises ImportError that says what for."""
    try:
        return importlib.import_module(name)
    except ImportError as e:
        raise ImportError(f"{purpose} needs {name.split('.')[0]}, which is not installed") from e


def options(verb: str) -> Callable[[_Function], _Function]:
    """Gives a function the options of a verb as keywords: names, kinds, defaults and help of the table by which the command parses."""

    def given(function: _Function) -> _Function:
        own = inspect.signature(function)
        kept = [p for p in own.parameters.values() if p.kind is not p.VAR_KEYWORD]
        further = [row for row in _KEYWORDS[verb] if row[0] not in own.parameters]
        made = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind) for name, kind, default, _ in further]
        setattr(function, "__signature__", own.replace(parameters=[*kept, *made]))
        function.__doc__ = f"{function.__doc__}\n" + "".join(f"    {name}: {in_keywords(text)}\n" for name, _, _, text in further)
        return function

    return given


def _toml_value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        escaped = "".join(f"\\u{ord(c):04x}" if ord(c) < 0x20 or ord(c) == 0x7F or c in '"\\' else c for c in value)
        return f'"{escaped}"'
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_toml_key(k)} = {_toml_value(v)}" for k, v in value.items() if v is not None) + " }"
    if isinstance(value, (int, float)):
        return repr(value)
    if hasattr(value, "tolist"):  # numpy
        return _toml_value(value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml_value(v) for v in value) + "]"
    raise TypeError(f"expected text, a number, a list or a dict, got {type(value).__name__}")


def _toml_key(key: Any) -> str:
    if not isinstance(key, str):
        raise TypeError(f"expected a key of text, got {type(key).__name__}")
    return _toml_value(key)


def toml(table: Mapping[str, Any]) -> str:
    """A table as TOML: plain values first, then tables, and lists of tables as [[key]]. None is left out."""
    lines: list[str] = []
    tables: list[str] = []
    for key, value in table.items():
        if value is None:
            continue
        several = isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(v, Mapping) for v in value)
        for part in (value if several else [value]) if several or isinstance(value, Mapping) else []:
            head = f"[[{_toml_key(key)}]]" if several else f"[{_toml_key(key)}]"
            tables.append(head + "\n" + "".join(f"{_toml_key(k)} = {_toml_value(v)}\n" for k, v in part.items() if v is not None))
        if not several and not isinstance(value, Mapping):
            lines.append(f"{_toml_key(key)} = {_toml_value(value)}\n")
    return "".join(lines) + "\n" + "\n".join(tables)
