"""The notebook of the documents runs from top to bottom."""

import pytest
from conftest import REPOSITORY


def test_the_first_hour_runs() -> None:
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    notebook = nbformat.read(REPOSITORY / "docs" / "first-hour.ipynb", as_version=4)
    nbformat.validate(notebook)
    assert not any(cell.get("outputs") for cell in notebook.cells), "clear the outputs"
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": REPOSITORY / "docs"}}).execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert not [output for output in shown if output.get("name") == "stderr"]
    assert sum("image/png" in output.get("data", {}) for output in shown) == 3
    words = "".join(output.get("text", "") for output in shown)
    assert "Learned: all 17 limbs are located." in words and "calibrated" in words.lower(), words
