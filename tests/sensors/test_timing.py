"""The cost table names every stage of every configuration and adds up."""

import pytest

from sensors.scaling import two_processes
from sensors.slip_timing import SLIP_STAGES
from sensors.timing import CONFIGURATIONS, SLIP, STAGES, TAXEL_STAGES, TAXELS, frame_cost


@pytest.mark.slow
def test_rows_cover_every_stage_and_the_total_is_their_sum():
    rows = frame_cost(repeats=1)
    assert {(row["sensor"], row["stage"]) for row in rows} == {
        *((sensor, stage) for sensor in CONFIGURATIONS for stage in STAGES),
        *((SLIP, stage) for stage in SLIP_STAGES),
        *((TAXELS, stage) for stage in TAXEL_STAGES),
    }
    for sensor in CONFIGURATIONS:
        cost = {row["stage"]: row["ms_p50"] for row in rows if row["sensor"] == sensor}
        parts = sum(cost[stage] for stage in STAGES[:4])
        assert cost["frame total"] == pytest.approx(parts, rel=0.35)


@pytest.mark.slow
def test_two_processes_press_beside_one_another():
    found = two_processes(rounds=2, presses=4)
    assert 0 < found["low"] <= found["ratio"] <= found["high"] < 4
    assert (found["rounds"], found["presses"]) == (2, 4)


def test_no_repeats_are_refused():
    with pytest.raises(ValueError, match="repeats"):
        frame_cost(0)
    with pytest.raises(ValueError, match="rounds"):
        two_processes(0)
