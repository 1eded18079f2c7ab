"""The examples of the documentation run."""

import doctest
import pathlib
import re

import numpy as np

import scphd

GUIDE = pathlib.Path(__file__).parents[3] / "docs" / "python.md"


def test_the_example_of_the_package():
    found = doctest.testmod(scphd)
    assert found.attempted > 5 and found.failed == 0


def test_the_example_of_the_guide(world):
    example = re.search(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL).group(1)
    recording = [(control, 0.1, scan) for control, scan in (world.step() for _ in range(20))]
    names = {"recording": recording, "x_m": 2.0, "y_m": 0.0}
    exec(example, names)
    assert names["pose"].covariance.shape == (3, 3) and names["features"].positions_m.shape[1] == 2
    assert names["report"].measurements == len(recording[-1][2]) and np.isfinite(names["pose"].mean).all()
