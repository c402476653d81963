"""The slip suites as they are committed."""

import pytest

from vtbench.config import load_scene, load_suite
from vtbench.run.detection.methods import BASELINE, with_baseline
from vtbench.tasks import TASKS


@pytest.mark.parametrize("name", ["slip", "slip-full"])
def test_a_slip_suite_reads_its_scenes_and_shows_the_baseline(name):
    suite = load_suite(name)
    for spec in suite.datasets:
        assert load_scene(spec.scene).kind == "slide"
    for entry in suite.entries:
        if TASKS.get(entry.task).reads == "slides":
            assert BASELINE in with_baseline(entry.methods)
            assert entry.probes


def test_the_full_suite_supports_a_tenth_of_an_alarm_a_minute():
    scene = load_scene("fvsight-slip/negatives")
    assert scene.n_samples * scene.motion.negative_s / 60 >= 300
    (spec,) = [spec for spec in load_suite("slip-full").datasets if spec.id == "negatives"]
    assert spec.samples is None
