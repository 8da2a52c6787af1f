"""The documentation's Python runs: docs/start/library.md from top to bottom, and every notebook, which prints what it shows: the same words, and
numbers within 1 %. With IMULAB_WRITE_DOCS in the environment (./dev docs --write) the notebooks are written anew instead."""

import os
import pathlib
import re

import pytest

docs = pathlib.Path(os.environ["IMULAB_SOURCE"]) / "docs"


@pytest.mark.filterwarnings("ignore::imulab.DataWarning")
def test_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    blocks = re.findall(r"^```python\n(.*?)^```", (docs / "start/library.md").read_text(), re.DOTALL | re.MULTILINE)
    assert len(blocks) >= 5
    for block in blocks:
        exec(compile(block, "library.md", "exec"), names)
    assert "gyro: 26399 samples; expected 26400" in capsys.readouterr().out
    assert {"calibration.json", "page.html", "session", "procedure.toml"} <= {p.name for p in tmp_path.iterdir()}


def parts(text):
    """Words, with # in place of numbers and without the time of day; the numbers."""
    number = r"(?<![A-Za-z_0-9])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
    text = re.sub(r"\d{4}-\d\d-\d\dT[\d:.]+Z", "", text)
    return re.sub(number, "#", text).split(), [float(n) for n in re.findall(number, text)]


def printed(book):
    """What its cells print: pictures and warnings are not compared."""
    outputs = [o for cell in book.cells for o in cell.get("outputs", [])]
    return "\n".join(o["text"] if o["output_type"] == "stream" else o["data"]["text/plain"] for o in outputs if o.get("name") != "stderr")


def test_other_numbers_are_found():
    assert parts("x1 by -2.5e-3 m\n 2026-01-02T03:04:05Z") == (["x1", "by", "#", "m"], [-0.0025])


@pytest.mark.skipif("LD_PRELOAD" in os.environ, reason="a kernel is an interpreter of its own")
@pytest.mark.parametrize("notebook", sorted((docs / "notebooks").glob("*.ipynb")), ids=lambda p: p.stem)
def test_notebook(notebook, tmp_path):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("matplotlib")
    book = nbformat.read(notebook, as_version=4)
    assert any(cell.get("outputs") for cell in book.cells), "committed without its outputs"
    shown = parts(printed(book))
    client = nbclient.NotebookClient(book, timeout=300, record_timing=False, resources={"metadata": {"path": str(tmp_path)}})
    client.execute()  # a failing cell raises
    words, numbers = parts(printed(book))
    if "IMULAB_WRITE_DOCS" in os.environ:
        for output in (o for cell in book.cells for o in cell.get("outputs", []) if o.get("name") == "stderr"):
            output["text"] = re.sub(r"/\S*ipykernel_\S*?:", "cell:", output["text"])
        nbformat.write(book, notebook)
    else:
        assert words == shown[0]
        assert numbers == pytest.approx(shown[1], rel=0.01)
