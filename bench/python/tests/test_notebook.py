"""The example is executed, as a user would."""

import json
import shutil
import subprocess
import sys

import pytest
from conftest import PROJECT

EXAMPLES = PROJECT / "datasets/examples"


@pytest.mark.long
def test_the_notebook_draws_what_accuracy_costs(tmp_path):
    pytest.importorskip("nbconvert")
    pytest.importorskip("ipykernel")
    for name in ("my_mesh.ipynb", "knee.py"):
        shutil.copy(EXAMPLES / name, tmp_path)
    done = subprocess.run([sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute", "--output", "done", "my_mesh.ipynb"],
                          cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    cells = json.loads((tmp_path / "done.ipynb").read_text())["cells"]
    outputs = [output for cell in cells for output in cell.get("outputs", [])]
    assert len([output for output in outputs if "image/png" in output.get("data", {})]) == 2
    assert "Run(my_knee with bvh: ok" in json.dumps(outputs)
    assert not [output for output in outputs if output.get("name") == "stderr"], "it warns"


def test_the_notebook_in_the_project_has_no_outputs():
    cells = json.loads((EXAMPLES / "my_mesh.ipynb").read_text())["cells"]
    assert not [cell for cell in cells if cell.get("outputs")]
