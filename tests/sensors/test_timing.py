"""The cost table gives every stage what it spends, and costs that need no clock do not grow."""

import numpy as np
import pytest

from sensors import scaling, timing
from sensors.fvsight import FVSightParameters, FVSightUnit, fvsight_unit
from sensors.objects import names
from sensors.press import presented_gap
from sensors.scaling import two_processes
from sensors.scene import PressScene
from sensors.slip_timing import SLIP_STAGES
from sensors.timing import CONFIGURATIONS, SLIP, STAGES, TAXEL_STAGES, TAXELS, WARM, frame_cost, press_stages

COARSE = FVSightParameters(grid=32)


class Clock:
    """Stands still but for the milliseconds that work is said to take."""

    now_ms = 0

    def __call__(self):
        return 1_000_000 * self.now_ms

    def charge(self, work, milliseconds):
        def slower(*given, **named):
            self.now_ms += milliseconds
            return work(*given, **named)

        return slower


def test_every_stage_is_charged_for_its_own_work_and_the_frame_for_the_four_before_it(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(timing.time, "process_time_ns", clock)
    monkeypatch.setattr(timing, "presented_gap", clock.charge(timing.presented_gap, 1))
    monkeypatch.setattr(timing, "taxel_history", clock.charge(timing.taxel_history, 1000))
    monkeypatch.setattr(FVSightUnit, "frame", clock.charge(FVSightUnit.frame, 100))
    # the history solves thrice more, and observes what it solved
    monkeypatch.setattr(FVSightUnit, "solve", clock.charge(FVSightUnit.solve, 10))
    monkeypatch.setattr(FVSightUnit, "observe", clock.charge(FVSightUnit.observe, 30))
    scene = PressScene(id="timing", title="timing", sensor=COARSE)
    spent = press_stages(scene, FVSightUnit(COARSE, 0), scene.object_names[0], 0, np.random.default_rng(0))
    parts = {"place": 1, "contact": 10, "taxels": 30, "render": 100}
    assert spent == {**parts, "frame total": 141, "force history": 1000 + 3 * 40, WARM: 10}
    assert tuple(spent) == STAGES


@pytest.mark.slow
def test_rows_cover_every_stage_and_count_every_press():
    rows = frame_cost(repeats=1)
    assert {(row["sensor"], row["stage"]) for row in rows} == {
        *((sensor, stage) for sensor in CONFIGURATIONS for stage in STAGES),
        *((SLIP, stage) for stage in SLIP_STAGES),
        *((TAXELS, stage) for stage in TAXEL_STAGES),
    }
    assert {row["n"] for row in rows if row["sensor"] in CONFIGURATIONS} == {27}


class Pool:
    """A pool whose presses take a second each: at once, or with `turns` one process after the other."""

    turns, now_s = False, 0.0

    def __init__(self, *_, **__):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def map(self, _, shares):
        type(self).now_s += (sum if self.turns else max)(shares)
        return shares


@pytest.mark.parametrize(("turns", "ratio"), [(False, 2.0), (True, 1.0)])
def test_processes_beside_one_another_press_twice_as_much_and_in_turns_no_more(monkeypatch, turns, ratio):
    monkeypatch.setattr(Pool, "turns", turns)
    monkeypatch.setattr(scaling, "ProcessPoolExecutor", Pool)
    monkeypatch.setattr(scaling.time, "perf_counter", lambda: Pool.now_s)
    assert two_processes(rounds=3, presses=4) == {
        "ratio": ratio, "low": ratio, "high": ratio, "rounds": 3, "presses": 4,
    }  # fmt: skip


def test_a_process_presses_as_often_as_it_is_asked(monkeypatch):
    pressed = []
    monkeypatch.setattr("sensors.press.simulate", lambda scene, index, seed: pressed.append(index))
    assert scaling._press_all(29) == 29
    assert pressed == [*range(27), 0, 1]


@pytest.mark.parametrize("sensor", CONFIGURATIONS, ids=["skin", "pad"])
def test_a_press_takes_few_linear_solves_and_a_warm_one_fewer(sensor):
    """Cost without a clock: measured 2 to 9 solves cold and 1 to 3 warm over the 27 objects."""
    unit = fvsight_unit(CONFIGURATIONS[sensor], 0)
    for name in names()[::13][:2]:
        gap = presented_gap(name, unit, (0.0, 0.0, 0.0), 56e-3)
        cold = unit.solve(gap, 5.0)
        warm = unit.solve(gap, 5.0, unit.solve(gap, 4.75).pressure)
        assert cold.iterations <= 12
        assert warm.iterations <= min(4, cold.iterations)


def test_no_repeats_are_refused():
    with pytest.raises(ValueError, match="repeats"):
        frame_cost(0)
    with pytest.raises(ValueError, match="rounds"):
        two_processes(0)
