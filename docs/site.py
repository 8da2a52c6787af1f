"""The manual as a site, for ./dev docs: README.md as its home, the pages, a page a verb from its help, the Python API from its docstrings -> HTML by
Sphinx in build/docs.

    docs/site.py BUILD      the folder with the command, and the Python module below it
"""

import importlib
import inspect
import os
import pathlib
import re
import shutil
import subprocess
import sys

root = pathlib.Path(__file__).resolve().parent.parent
docs = root / "docs"
build = pathlib.Path(sys.argv[1]).resolve()
pages = root / "build" / "manual"
repository = "https://github.com/imulab/imulab/blob/main/"

CONFIGURATION = """
project = "imulab"
extensions = ["myst_parser"]
root_doc = "index"
html_theme = "furo"
html_title = "imulab"
html_copy_source = False
myst_heading_anchors = 4
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
"""

PARTS = [("Start", "start"), ("Reference", "reference"), ("Verbs", "verbs"), ("Theory", "theory"), ("Evidence", "evidence")]


def verbs() -> list[str]:
    help_text = subprocess.run([build / "imulab", "--help"], check=True, capture_output=True, text=True).stdout
    return [verb for verb in re.findall(r"^  ([a-z]+)  ", help_text, re.MULTILINE) if verb != "help"]


def verb_page(verb: str) -> str:
    text = subprocess.run([build / "imulab", "help", verb], check=True, capture_output=True, text=True).stdout
    return f"# imulab {verb}\n\n[The command](../reference/command.md) lists options that verbs share, and exit codes.\n\n```text\n{text}```\n"


def member_text(name: str, member: object) -> str:
    try:
        signature = str(inspect.signature(member))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        signature = ""
    plain = re.sub(r"([\\`*_{}\[\]<>#|~$])", r"\\\1", inspect.getdoc(member) or "")
    lines = [line for line in plain.splitlines() if line]
    return f"```python\n{name}{signature}\n```\n\n" + "\\\n".join(lines) + "\n"


def python_page() -> str:
    sys.path.insert(0, str(build / "python"))
    module = importlib.import_module("imulab")
    text = "# Python API\n\n[Use Python](../start/library.md) has examples. This page is made from the module's docstrings.\n"
    for name in sorted(module.__all__, key=str.lower):
        thing = getattr(module, name)
        text += f"\n## {name}\n\n{member_text(name, thing)}"
        if not inspect.isclass(thing):
            continue
        for own, member in sorted(vars(thing).items()):
            if own.startswith("_") or not inspect.getdoc(member):
                continue
            member = member.__func__ if isinstance(member, (classmethod, staticmethod)) else member
            text += f"\n### {name}.{own}\n\n{member_text(own, member)}"
    return text


def links_inside(page: pathlib.Path) -> str:
    """The text of a page with the links that it has in the manual. README.md is there as index.md; files outside the manual are in the repository."""
    folder = page.parent if page.is_relative_to(docs) else docs  # where the page is in the manual

    def fixed(found: re.Match[str]) -> str:
        target = found[1]
        if target.startswith("http"):
            return found[0]
        at = (page.parent / target).resolve()
        at = docs / "index.md" if at == root / "README.md" else at
        return f"]({os.path.relpath(at, folder)}" if at.is_relative_to(docs) else f"]({repository}{at.relative_to(root)}"

    return re.sub(r"\]\(([^)#\s]+)", fixed, page.read_text())


def contents(folder: str) -> str:
    """The pages of a folder in the order of the index; what it does not list by name."""
    index = (docs / "README.md").read_text()
    entries = [p.relative_to(pages).as_posix() for p in (pages / folder).rglob("*.md")]
    places = {entry: index.find(f"({entry})") for entry in entries}
    entries.sort(key=lambda entry: (places[entry] < 0, places[entry], entry))
    return "\n".join(entry.removesuffix(".md") for entry in entries)


def main() -> None:
    shutil.rmtree(pages, ignore_errors=True)
    shutil.copytree(docs, pages)
    for page in docs.rglob("*.md"):
        (pages / page.relative_to(docs)).write_text(links_inside(page))
    (pages / "verbs").mkdir()
    for verb in verbs():
        (pages / "verbs" / f"{verb}.md").write_text(verb_page(verb))
    (pages / "reference" / "python-api.md").write_text(python_page())
    home = links_inside(root / "README.md") + "\n```{toctree}\n:hidden:\n\nREADME\n```\n"
    for title, folder in PARTS:
        home += f"\n```{{toctree}}\n:caption: {title}\n:hidden:\n\n{contents(folder)}\n```\n"
    (pages / "index.md").write_text(home)
    (pages / "conf.py").write_text(CONFIGURATION)
    subprocess.run([sys.executable, "-m", "sphinx", "-q", "-b", "html", pages, root / "build" / "docs"], check=True)


main()
