"""The studies run: a notebook, a sweep on two workers of Dask, and the comparison with Stone Soup. Not part of the quick tests."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE))

import stone_soup  # noqa: E402
import sweep  # noqa: E402


@pytest.fixture(scope="module")
def cluster():
    """The address of a cluster of two workers on this machine."""
    from dask.distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as local:
        yield local.scheduler_address


def test_two_workers_give_the_bits_of_one_process(cluster):
    here, there = sweep.sweep(range(4)), sweep.sweep(range(4), cluster=cluster)
    assert here == there and len({row[-1] for row in here}) == len(here) == 20


def test_the_notebook_runs(cluster, monkeypatch, tmp_path):
    import nbclient
    import nbformat

    monkeypatch.setenv("SCPHD_CLUSTER", cluster)
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    notebook = nbformat.read(HERE / "own_data.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(HERE)}}).execute()
    text = "".join(
        output.get("text", "") for cell in notebook.cells for output in cell.get("outputs", []) if output.output_type == "stream"
    )
    print(text)
    pictures = [output for cell in notebook.cells for output in cell.get("outputs", []) if "image/png" in output.get("data", {})]
    assert len(pictures) == 3
    assert "'LOST'" in text.split("lifted:")[1]
    assert "equal to the last bit; on tcp://" in text


def test_both_trackers_find_the_targets():
    """Neither is far behind the other; `stone_soup.py` prints the figures."""
    rows = stone_soup.compare(range(2), scans=40)
    ours, theirs = (rows[name].mean(axis=0) for name in ("scphd", "Stone Soup"))
    print("OSPA m, number, RMSE m, seconds a scan:", ours, theirs)
    assert ours[0] < 1.2 * theirs[0] and ours[2] < 1.1 * theirs[2]
    assert ours[3] < 0.1 * theirs[3]


def test_the_score_is_the_metric():
    none, one, two = np.zeros((0, 2)), np.array([[1.0, 0.0]]), np.array([[1.0, 0.5], [9.0, 9.0]])
    assert stone_soup.ospa_m(none, none) == 0.0
    assert stone_soup.ospa_m(one, none) == stone_soup.CUT_OFF_M
    assert stone_soup.ospa_m(one, two) == pytest.approx((0.5 + stone_soup.CUT_OFF_M) / 2)


def test_the_types_are_those_of_the_module(tmp_path):
    """mypy compares the stubs with what is there. The list of names is the compiler's own."""
    allowed = tmp_path / "allowed.txt"
    allowed.write_text("scphd._native.__all__\n")
    command = [sys.executable, "-m", "mypy.stubtest", "scphd", "--allowlist", str(allowed)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
