"""The documentation's Python runs: docs/start/python.md from top to bottom, and every notebook."""

import os
import pathlib
import re

import pytest

docs = pathlib.Path(os.environ["IMULAB_SOURCE"]) / "docs"


@pytest.mark.filterwarnings("ignore::imulab.DataWarning")
def test_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    blocks = re.findall(r"^```python\n(.*?)^```", (docs / "start/python.md").read_text(), re.DOTALL | re.MULTILINE)
    assert len(blocks) >= 5
    for block in blocks:
        exec(compile(block, "python.md", "exec"), names)
    assert "gyro: 26399 samples; expected 26400" in capsys.readouterr().out
    assert {"calibration.json", "page.html", "session", "procedure.toml"} <= {p.name for p in tmp_path.iterdir()}


@pytest.mark.skipif("LD_PRELOAD" in os.environ, reason="a kernel is an interpreter of its own")
@pytest.mark.parametrize("notebook", sorted((docs / "notebooks").glob("*.ipynb")), ids=lambda p: p.stem)
def test_notebook(notebook, tmp_path):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("matplotlib")
    book = nbformat.read(notebook, as_version=4)
    assert any(cell.get("outputs") for cell in book.cells), "committed without its outputs"
    pattern = pathlib.Path("evidence/papers/xu2024/pattern.toml")
    (tmp_path / pattern.parent).mkdir(parents=True)
    (tmp_path / pattern).write_text((docs / pattern).read_text())
    (tmp_path / "notebooks").mkdir()
    nbclient.NotebookClient(book, timeout=300, resources={"metadata": {"path": str(tmp_path / "notebooks")}}).execute()  # a failing cell raises
