#!/usr/bin/env python3
"""docs/words.py: words, lengths of sentences, parentheses and semicolons of README.md, the other pages beside it and docs/, without code, tables,
comments and the list of references."""
import re
import statistics
import sys
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]


def prose(page: str) -> str:
    page = re.sub(r"^```.*?^```", "", page.split("\n## References\n")[0], flags=re.M | re.S)
    page = re.sub(r"\]\([^)]*\)", "]", page)  # what a link leads to
    page = re.sub(r"(?<=\n\n)(?:(?:    .*)?\n)+", "\n", page)  # an indented block
    return "\n".join(line for line in page.splitlines() if not line.startswith(("|", "<!--")))


def sentences(text: str) -> list[int]:
    """Their numbers of words. Headings and list items are sentences of their own."""
    parts = re.split(r"(?<=[.!?:])\s+(?=[A-Z`*\[])|\n\s*\n|\n(?=\s*(?:[-#]|\d+\.) )", text)
    return [n for part in parts if (n := words(part)) > 0]


def words(text: str) -> int:
    return sum(any(c.isalnum() for c in word) for word in text.split())


def row(name: str, text: str) -> str:
    lengths, count = sentences(text), max(words(text), 1)
    long = 100 * sum(n > 30 for n in lengths) / max(len(lengths), 1)
    return (f"{words(text):6}  {statistics.median(lengths or [0]):6.0f}  {long:10.0f}  {1000 * text.count('(') / count:9.0f}  "
            f"{1000 * text.count(';') / count:9.0f}  {name}")


def main() -> None:
    pages = {str(p.relative_to(SOURCE)): prose(p.read_text()) for p in sorted([*SOURCE.glob("*.md"), *(SOURCE / "docs").rglob("*.md")])}
    print(" words  median  above 30 %  ( / 1,000  ; / 1,000")
    for name, text in pages.items():
        print(row(name, text))
    print(row("all", "\n\n".join(pages.values())))


if __name__ == "__main__":
    sys.exit(main())
