"""`vtbench sparse-cost`: what it prints adds up."""

import json

import pytest


@pytest.mark.slow
def test_rows_goals_and_agreement_with_the_peers(vtbench, monkeypatch):
    monkeypatch.setattr("fusion.timing.QUERY_ATOMS", 4000)
    monkeypatch.setattr("fusion.timing.PEER_ATOMS", 400)
    found = json.loads(vtbench("sparse-cost", "--atoms", "60", "--nonzeros", "5", "--repeats", "2", "--json").out)
    rows = {row["form"]: row for row in found["rows"]}
    assert found["n_nonzero_coefs"] == 5
    for row in rows.values():
        assert 0 < row["us"][1] <= row["us"][0] <= row["us"][2]
        if row["goal"] is not None:
            assert row["met"] == (row["ratio"][0] <= row["goal"] if row["most"] else row["ratio"][0] >= row["goal"])
    peers = [row for name, row in rows.items() if "scikit-learn" in name or "dictlearn" in name]
    assert peers
    for row in peers:
        assert row["same_support"] == 1.0
        assert row["coef_difference"] < 1e-12


@pytest.mark.slow
def test_a_hundred_thousand_queries_stay_below_two_gigabytes():
    from fusion.peak_memory import peak_memory

    figures = peak_memory(100_000, 1000, 2)
    assert figures["labels"] == 100_000
    assert 5e7 < figures["peak_bytes"] < 2e9


@pytest.mark.slow
def test_a_child_that_fails_is_one_line():
    from fusion.peak_memory import peak_memory

    with pytest.raises(OSError, match="the process that predicts 5 queries against 0 atoms failed"):
        peak_memory(5, 0, 1)


def test_bad_sizes_are_refused(vtbench):
    assert vtbench("sparse-cost", "--atoms", "1").code == 2
