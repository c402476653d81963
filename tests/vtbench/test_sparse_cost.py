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

    figures = peak_memory(100_000, 5000, 2)
    assert figures["labels"] == 100_000
    assert 8 * 5000**2 < figures["peak_bytes"] < 2e9  # the Gram matrix alone is the lower bound


@pytest.mark.slow
def test_a_child_that_fails_is_one_line():
    from fusion.peak_memory import peak_memory

    with pytest.raises(OSError, match="the process that predicts 5 queries against 0 atoms failed"):
        peak_memory(5, 0, 1)


@pytest.mark.slow
def test_each_dictionary_is_printed_once_it_is_measured(vtbench, monkeypatch):
    from fusion import timing

    def second_fails(n_atoms, *args):
        if n_atoms == 8:
            raise ValueError("no room")
        return [timing.Cost(n_atoms, "some form", (1.0, 1.0, 1.0))]

    monkeypatch.setattr("fusion.timing.sparse_cost", second_fails)
    answer = vtbench("sparse-cost", "--atoms", "60", "8", "--nonzeros", "5")
    assert answer.code == 2
    assert "some form" in answer.out


def test_bad_sizes_are_refused_before_anything_is_measured(vtbench):
    assert vtbench("sparse-cost", "--atoms", "1").code == 2
    answer = vtbench("sparse-cost", "--atoms", "60", "5", "--repeats", "1")
    assert answer.code == 2
    assert "--nonzeros 10" in answer.err
    assert answer.out == ""
