"""A fitted pipeline says of new samples what the cell said of its test part."""

import json

import numpy as np
import pytest

from tests.vtbench.run import small
from vtbench.run.choose import Setting
from vtbench.run.evaluate import evaluate
from vtbench.run.fitted import fit_pipeline
from vtbench.run.methods import METHODS


@pytest.mark.parametrize("method", ["ksc", "jksc", "knn", "wknn", "svm"])
@pytest.mark.parametrize("feed", [small.FORCE, small.FUSED], ids=["force", "fused"])
def test_labels_are_those_of_the_cell(method, feed):
    work = small.work(METHODS.get(method), feed)
    outcome = evaluate(work)
    for number, fold in enumerate(work.split.folds):
        setting = Setting(**json.loads(str(outcome.predictions["choices"][number])))
        take = lambda rows: {name: block[rows] for name, block in work.blocks.items()}  # noqa: E731
        pipeline = fit_pipeline(work.method, feed, setting, take(fold.train), work.labels[fold.train])
        expected = outcome.predictions["label"][outcome.predictions["fold"] == number]
        np.testing.assert_array_equal(pipeline.predict(take(fold.test)), expected)
        one_by_one = [pipeline.predict(take(fold.test[at : at + 1]))[0] for at in range(len(fold.test))]
        assert np.mean(one_by_one == expected) > 0.95  # a tie may fall otherwise by the rounding of a product
