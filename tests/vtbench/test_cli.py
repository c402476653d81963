import json
import os
import re
import subprocess
import sys
from importlib import import_module

import pytest

import vtbench as package
from fusion import features
from vtbench import cli

COMMANDS = (
    *("list", "objects", "validate", "generate", "import", "fetch"),
    *("show", "run", "score", "board", "frame-cost", "env"),
)
HEAVY = (
    "torch",
    "numpy",
    "scipy",
    "sklearn",
    "cv2",
    "pandas",
    "pyarrow",
    "matplotlib",
    "onnxruntime",
    "pydantic",
    "yaml",
)


def python(*words, **changes):
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, env={**os.environ, **changes})


@pytest.mark.parametrize("words", [["--help"], ["--version"], ["run", "--help"], ["generate", "--help"]])
def test_help_imports_nothing_heavy(words):
    code = f"import sys, vtbench.cli; code = vtbench.cli.main({words}); print(code, *sys.modules)"
    answer = python("-c", code)
    assert answer.returncode == 0, answer.stderr
    code, *modules = answer.stdout.splitlines()[-1].split()
    assert code == "0"
    loaded = {name.partition(".")[0] for name in modules}
    assert loaded.isdisjoint(HEAVY)
    assert "vtbench" in loaded


def test_the_public_names_load_and_importing_the_package_loads_none_of_them():
    answer = python("-c", "import sys, vtbench; print(*sys.modules)")
    assert {name.partition(".")[0] for name in answer.stdout.split()}.isdisjoint(HEAVY)
    for name in package.__all__:
        assert callable(getattr(package, name)), name
        assert name in dir(package)
    assert re.match(r"\d+\.\d+", package.__version__)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = package.nothing


@pytest.mark.parametrize("home", ["fusion", "fusion.neural", "vtbench.exporting"])
def test_a_package_of_the_house_is_reached_from_the_door(home):
    """Its public names are those of `vtbench`, the same objects; of `fusion.features` what a user calls."""
    part = import_module(home)
    for name in part.__all__:
        assert getattr(package, name) is getattr(part, name)
    assert package.get_backbone is features.get_backbone
    assert package.backbone_names is features.backbone_names


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_an_example(vtbench, command):
    answer = vtbench(command, "--help")
    assert answer.code == 0
    assert answer.out.startswith(f"usage: vtbench {command}")
    assert f"\nexamples:\n  vtbench {command}" in answer.out
    assert "--json" in answer.out


def test_the_help_names_every_command(vtbench):
    answer = vtbench("--help")
    assert answer.code == 0
    assert all(re.search(rf"^    {command}\b", answer.out, re.MULTILINE) for command in COMMANDS)
    assert vtbench().out == answer.out
    assert vtbench().code == cli.BAD_INPUT


def test_the_version_is_the_distributions(vtbench):
    answer = vtbench("--version")
    assert (answer.code, answer.out) == (0, f"vtbench {package.__version__}\n")


def test_the_module_runs_like_the_script():
    answer = python("-m", "vtbench", "list", "scens")
    assert answer.returncode == 2
    assert answer.stderr.startswith("vtbench: error: ")
    assert answer.stdout == ""


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["lst"], "unknown command 'lst'; did you mean 'list'?"),
        (["--vresion"], "unknown option '--vresion'; did you mean '--version'?"),
        (["list", "scens"], "unknown kind 'scens'; did you mean 'scenes'"),
        (["list", "--jsn"], "unknown option '--jsn'; did you mean '--json'?"),
        (["list", "scenes", "extra"], "unrecognized arguments: extra"),
        (["generate", "fvsight-press", "--samles", "3"], "unknown option '--samles'; did you mean '--samples'?"),
        (["generate", "fvsight-press"], "required: -o/--out"),
        (["generate", "fvsight-press", "-o"], "argument -o/--out: expected one argument"),
        (["generate", "fvsight-press", "-o", "x", "--samples", "-3"], "at least 1, got '-3'"),
        (["generate", "fvsight-press", "-o", "x", "--samples", "0"], "at least 1, got '0'"),
        (["generate", "fvsight-press", "-o", "x", "--samples", "many"], "at least 1, got 'many'"),
        (["generate", "fvsight-press", "-o", "x", "--samples=2.5"], "at least 1, got '2.5'"),
        (["generate", "fvsight-press", "-o", "x", "--jobs", "0"], "at least 1, got '0'"),
        (["generate", "fvsight-press", "-o", "x", "-j0"], "at least 1, got '0'"),
        (["generate", "fvsight-press", "-o", "x", "--seed", "-1"], "at least 0, got '-1'"),
        (
            ["generate", "fvsight-press", "-o", "x", "--truth", "pressur"],
            "unknown field 'pressur'; did you mean 'pressure'?",
        ),
        (["generate", "fvsight-press", "-o", "x", "--variation", "hrd"], "'hrd'; did you mean 'hard'?"),
        (["generate", "fvsight-pres", "-o", "x"], "unknown scene 'fvsight-pres'; did you mean 'fvsight-press'"),
        (["generate", "nowhere.yaml", "-o", "x"], "nowhere.yaml: no such file"),
        (["run", "quik", "-o", "x"], "unknown suite 'quik'; did you mean 'quick'?"),
        (["run", "quick", "-o", "x", "--device", "gpu"], "device"),
        (["fetch", "fabric-slide16"], "did you mean 'fabricslide16'?"),
        (["objects", "coin-1-eur"], "did you mean 'coin-1-euro'?"),
        (["objects", "--nearest", "0"], "at least 1, got '0'"),
        (["show", "nowhere", "-o", "x.png"], "nowhere"),
        (["show", "nowhere", "-o", "x.jpg"], "expected a file that ends in .png, got 'x.jpg'"),
        (["import", "nowhere", "-o", "x"], "nowhere"),
        (["score", "nowhere"], "nowhere: expected the folder of a run"),
        (["board", "nowhere", "-o", "x"], "nowhere: expected the folder of a run"),
        (["validate", "nowhere"], "nowhere: no such file or folder"),
        (["validate", "quik"], "did you mean 'quick'?"),
        (["frame-cost", "--repeats", "none"], "at least 1, got 'none'"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(refused, words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert message in refused(*words)
    assert list(tmp_path.iterdir()) == []


def test_debugging_shows_the_traceback():
    answer = python("-m", "vtbench", "generate", "fvsight-pres", "-o", "x", VTBENCH_DEBUG="1")
    assert answer.returncode != 0
    assert "Traceback" in answer.stderr
    assert "ValueError: unknown scene" in answer.stderr


def fail_with(error):
    def run(args):
        raise error

    return run


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (ValueError("two\nlines"), 2, "vtbench: error: two lines\n"),
        (OSError(28, "No space left on device", "data/x"), 2, "vtbench: error: data/x: No space left on device\n"),
        (OSError("cannot write here"), 2, "vtbench: error: cannot write here\n"),
        (ValueError(), 2, "vtbench: error: ValueError\n"),
        (KeyError("x"), 70, "vtbench: internal error: KeyError: 'x' (a bug of vtbench: VTBENCH_DEBUG=1 shows where)\n"),
        (KeyboardInterrupt(), 130, "vtbench: interrupted; nothing was left half done\n"),
    ],
)
def test_an_exception_is_one_line_and_an_exit_code(vtbench, monkeypatch, error, code, message):
    monkeypatch.setattr("vtbench.commands.env.run", fail_with(error))
    answer = vtbench("env")
    assert (answer.code, answer.err) == (code, message)


def test_a_models_verdict_is_one_line(vtbench, monkeypatch):
    from pydantic import TypeAdapter, ValidationError

    with pytest.raises(ValidationError) as failure:
        TypeAdapter(dict[str, int]).validate_python({"a": "x", "b": "y"})
    monkeypatch.setattr("vtbench.commands.env.run", fail_with(failure.value))
    answer = vtbench("env")
    assert answer.code == 2
    assert answer.err.startswith("vtbench: error: a: Input should be a valid integer")
    assert answer.err.count("\n") == 1


@pytest.mark.parametrize("command", ["generate", "run", "fetch", "import"])
def test_who_interrupts_long_work_is_told_how_to_go_on(vtbench, monkeypatch, command, tmp_path):
    words = {
        "generate": ["fvsight-press", "-o", tmp_path],
        "run": ["quick", "-o", tmp_path],
        "fetch": ["fabricslide16"],
    }
    module = {"fetch": "bring", "import": "bring"}.get(command, command)
    name = {"fetch": "run_fetch", "import": "run_import"}.get(command, "run")
    monkeypatch.setattr(f"vtbench.commands.{module}.{name}", fail_with(KeyboardInterrupt()))
    answer = vtbench(command, *words.get(command, [tmp_path, "-o", tmp_path]))
    assert answer.code == 130
    assert answer.err.startswith("vtbench: interrupted; ")
    assert "the same command" in answer.err


def test_warnings_are_one_line(vtbench, monkeypatch, recwarn):
    import warnings

    seen = []

    def run(args):
        seen.append(warnings.formatwarning("two\nlines", UserWarning, "file.py", 3))
        return 0

    before = warnings.formatwarning
    monkeypatch.setattr("vtbench.commands.env.run", run)
    assert vtbench("env").code == 0
    assert seen == ["vtbench: warning: two lines\n"]
    assert warnings.formatwarning is before


def test_a_reader_that_went_away_is_no_error():
    command = f"{sys.executable} -m vtbench list; echo $? >&2"
    answer = subprocess.run(["bash", "-c", f"{{ {command}; }} | true"], capture_output=True, text=True)
    assert answer.stderr in ("141\n", "0\n")


def test_lists_hold_what_there_is(vtbench):
    answer = vtbench("list", "--json")
    assert answer.code == 0
    found = json.loads(answer.out)
    kinds = "scenes objects sensors backbones methods detectors tasks suites recordings"
    assert list(found) == kinds.split()
    assert len(found["objects"]) == 27
    assert all(row["about"] for kind in found if kind != "backbones" for row in found[kind])
    for kind, rows in found.items():
        text = vtbench("list", kind).out.splitlines()
        assert len(text) == 1 + len(rows)
        first = next(iter(rows[0]))
        assert all(line.startswith(row[first]) for line, row in zip(text[1:], rows, strict=True))


def test_the_environment_prints_and_parses(vtbench):
    found = json.loads(vtbench("env", "--json").out)
    text = vtbench("env").out
    assert found["version"] in text
    assert found["fingerprint"] in text
    assert found["cache"] in text


def test_the_nearest_objects_are_pairs_in_order(vtbench, monkeypatch, tmp_path):
    from sensors import objects

    pairs = [("coin-1-euro", "coin-2-euro", 0.25), ("comb", "coin-1-euro", 0.5), ("comb", "fork", 1.0)]
    monkeypatch.setattr(objects, "nearest_pairs", lambda count: pairs[:count])
    found = json.loads(vtbench("objects", "--nearest", "2", "--json").out)
    assert [(pair["object"], pair["like"], pair["rms_mm"]) for pair in found["nearest"]] == pairs[:2]
    of_one = json.loads(vtbench("objects", "coin-1-euro", "--json", "-o", tmp_path / "coin.png").out)
    assert [(pair["object"], pair["like"]) for pair in of_one["nearest"]] == [
        ("coin-1-euro", "coin-2-euro"),
        ("coin-1-euro", "comb"),
    ]
    assert (tmp_path / "coin.png").read_bytes().startswith(b"\x89PNG")
    assert objects.get("coin-1-euro").description in vtbench("objects", "coin-1-euro").out


def test_the_cost_of_a_frame_adds_up(vtbench, monkeypatch):
    from sensors import scaling, timing

    monkeypatch.setattr(timing, "CONFIGURATIONS", dict(list(timing.CONFIGURATIONS.items())[1:]))
    monkeypatch.setattr(timing, "measure_slip_frame", lambda rounds, seed: {"frame total": [2.0] * rounds})
    monkeypatch.setattr(
        scaling, "two_processes", lambda rounds: {"ratio": 1.9, "low": 1.8, "high": 2.0, "rounds": rounds}
    )
    found = json.loads(vtbench("frame-cost", "--repeats", "1", "--json").out)
    assert found["threads"] == 1
    assert found["two_processes"]["ratio"] == 1.9
    cost = {row["stage"]: row["ms_p50"] for row in found["rows"] if row["sensor"] in timing.CONFIGURATIONS}
    assert cost["contact"] <= cost["frame total"]
    out = vtbench("frame-cost", "--repeats", "1").out
    assert "frame total" in out
    assert "two processes press 1.90 times as fast" in out
