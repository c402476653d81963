"""Presses of four objects whose forces tell them apart, and a model that knows it."""

import pytest

from tests.vtbench.onnx_eval import graphs
from tests.vtbench.run import small
from vtbench.data import Dataset
from vtbench.onnx_eval.handed_in import Credit
from vtbench.onnx_eval.sandbox import Limits
from vtbench.onnx_eval.tested import on_datasets

TASK = "objects/interference/v1"


@pytest.fixture(scope="session")
def presses(tmp_path_factory):
    return small.write(tmp_path_factory.mktemp("evaluated") / "set")


@pytest.fixture(scope="session")
def tested(presses):
    return on_datasets(TASK, "own", None, [presses])


@pytest.fixture(scope="session")
def known(presses):
    """Forces and labels of the presses."""
    dataset = Dataset.open(presses)
    return dataset.force(), dataset.columns(["label"])["label"].to_numpy()


@pytest.fixture
def honest(tmp_path, known):
    return graphs.honest(tmp_path / "honest.onnx", *known)


@pytest.fixture
def judged(tmp_path, tested):
    """Evaluate a model and return its record; everything is written below `out`."""
    from vtbench.onnx_eval.evaluate import evaluate

    def run(model, time_s=60.0, memory_mb=1024):
        return evaluate(model, tested, Credit("someone", "Someone's"), tmp_path / "out", Limits(time_s, memory_mb))

    return run
