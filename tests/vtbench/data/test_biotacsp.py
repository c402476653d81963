"""Grasp readings: what the files say comes through, and what is wrong with one is named."""

import numpy as np
import pytest

from vtbench.data.biotacsp_stability_v2 import COLUMNS, PALMS, SOURCE, load_biotacsp_stability_v2
from vtbench.data.manifest import wrong_files
from vtbench.tasks import TASKS
from vtbench.tasks.grasp_biotacsp import published

TRAINED, UNSEEN = ("apple", "mug", "shoe"), ("bunny", "taz")


def write(root, ending="\n"):
    rng = np.random.default_rng(0)
    for palm in PALMS:
        for test, objects in (("", TRAINED), ("_test", UNSEEN)):
            lines = [",".join(COLUMNS)]
            for name in objects:
                for slipped in (0, 1, 1):
                    lines.append(",".join([name, str(slipped), *map(str, rng.integers(0, 4000, 72))]))
            (root / f"bts3v2_palm_{palm}{test}.csv").write_text(ending.join(lines) + ending, newline="")
    return root


class NoFeatures:
    def cached(self, identity, n, compute):
        raise AssertionError

    def us_per_sample(self, identity):
        return None


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_every_line_is_a_grasp(tmp_path, ending):
    grasps = load_biotacsp_stability_v2(write(tmp_path, ending))
    assert len(grasps) == 3 * 3 * (len(TRAINED) + len(UNSEEN))
    assert set(grasps.object[grasps.unseen]) == set(UNSEEN)
    assert grasps.slipped.mean() == pytest.approx(2 / 3)
    line = int(grasps.id[4].partition(":")[2])
    cells = (tmp_path / "bts3v2_palm_down.csv").read_text().splitlines()[line - 1].split(",")
    assert cells[0] == grasps.object[4]
    np.testing.assert_array_equal(np.array(cells[2:], float), grasps.electrodes[4])


def test_unseen_objects_stay_unseen_and_inner_folds_hold_out_objects(tmp_path):
    data = TASKS.get("grasp/biotacsp/v1").load(write(tmp_path), NoFeatures(), "")
    split = published(data, 0)
    (fold,) = split.folds
    objects = data.factor("object")
    assert set(objects[fold.train]) == set(TRAINED)
    assert set(objects[fold.test]) == set(UNSEEN)
    np.testing.assert_array_equal(split.inner_groups, objects)
    np.testing.assert_array_equal(split.interval_groups, objects)


def test_the_probes_know_no_electrode(tmp_path):
    data = TASKS.get("grasp/biotacsp/v1").load(write(tmp_path), NoFeatures(), "")
    np.testing.assert_array_equal(data.block("palm-pose").sum(1), 1.0)
    np.testing.assert_allclose(
        data.block("mean-levels")[:, 1], data.block("electrodes")[:, 24:48].mean(1, dtype=float), rtol=1e-5
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("th_biotac_24", "th_biotac_25", "expected the columns"),
        ("apple,0,", "apple,2,", "column 'slipped'"),
        ("apple,0,", "apple,0,1.5,", "not readable as CSV|no whole number"),
    ],
)
def test_a_file_that_is_not_as_published_is_named(tmp_path, old, new, message):
    path = write(tmp_path) / "bts3v2_palm_side.csv"
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(ValueError, match=rf"bts3v2_palm_side\.csv: .*({message})"):
        load_biotacsp_stability_v2(tmp_path)


def test_a_missing_file_says_what_brings_it(tmp_path):
    (write(tmp_path) / "bts3v2_palm_45_test.csv").unlink()
    with pytest.raises(ValueError, match="vtbench fetch biotacsp_stability_v2"):
        load_biotacsp_stability_v2(tmp_path)


def test_the_published_set_is_the_pinned_one(real_recordings):
    root = real_recordings("biotacsp_stability_v2")
    assert wrong_files(root, SOURCE.files) == []
    grasps = load_biotacsp_stability_v2(root)
    assert (len(grasps), int(grasps.unseen.sum())) == (5831, 1149)
    assert len(set(grasps.object[grasps.unseen])) == 10
    assert len(set(grasps.object[~grasps.unseen])) == 41
    assert int(grasps.slipped.sum()) == 2354 + 589


@pytest.mark.slow
def test_neighbours_score_what_was_seen_elsewhere(real_recordings):
    from sklearn.preprocessing import StandardScaler

    from fusion import WeightedKNN

    grasps = load_biotacsp_stability_v2(real_recordings("biotacsp_stability_v2"))
    scale = StandardScaler().fit(grasps.electrodes[~grasps.unseen])
    x = scale.transform(grasps.electrodes) / 72**0.5
    known = WeightedKNN(n_neighbors=10).fit(x[~grasps.unseen], grasps.slipped[~grasps.unseen])
    right = known.predict(x[grasps.unseen]) == grasps.slipped[grasps.unseen]
    assert right.mean() == pytest.approx(0.688, abs=0.03)
