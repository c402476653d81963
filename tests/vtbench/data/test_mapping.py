"""Folders of any layout: what the mapping says is what is read, and every problem has its place."""

import cv2
import numpy as np
import pytest
import yaml

from vtbench.data import Dataset, check_dataset, import_folder
from vtbench.data.import_report import dry_run
from vtbench.data.mapping import NEWTONS, Mapping, load_mapping
from vtbench.data.mapping_suggestion import suggest

OBJECTS = ("cup", "nut", "pen")
TAXELS = (1, 2, 10, 3)
PER_PRESS = {
    "forces": "*/*/*.csv",
    "each_file": "press",
    "skip_lines": 1,
    "delimiter": ";",
    "decimal": ",",
    "taxels": r"ch (\d+)",
    "force_unit": "mN",
    "forces_path": r"(?P<session>[^/]+)/(?P<object>[^/]+)/[^/]+$",
    "image": "{folder}/{stem}.png",
    "rest": "{session}/rest.png",
}


def picture(path, seed, size=(12, 16)):
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.random.default_rng(seed).integers(0, 256, (*size, 3), dtype=np.uint8))


def comma(value):
    return f"{value:.3f}".replace(".", ",")


@pytest.fixture
def per_press(tmp_path):
    """A file of six samples for each press, in folders of sessions and objects; returns the forces in newtons too."""
    folder = tmp_path / "rec"
    forces = {}
    for day, session in enumerate(("day-a", "day-b")):
        for number, name in enumerate(OBJECTS):
            for press in range(2):
                stem = folder / session / name / f"press_{press}"
                seed = 100 * day + 10 * number + press
                picture(stem.with_suffix(".png"), seed)
                samples = np.random.default_rng(seed).gamma(2.0, 100.0, (6, 4)).round(3)
                heading = ";".join(["t", *(f"ch {taxel}" for taxel in TAXELS)])
                rows = [";".join([comma(t / 100), *map(comma, row)]) for t, row in enumerate(samples)]
                stem.with_suffix(".csv").write_text("\n".join(["# a logger", heading, *rows]) + "\n")
                forces[f"{session}/{name}/press_{press}.png"] = samples[:, np.argsort(TAXELS)] * 1e-3
        picture(folder / session / "rest.png", 7)
    return folder, forces


@pytest.fixture
def one_table(tmp_path):
    """One table of counts, its images named by number."""
    folder = tmp_path / "table"
    counts = np.random.default_rng(0).integers(500, 900, (6, 3))
    lines = ["thing,how,left,right,top,frame"]
    for number, row in enumerate(counts):
        picture(folder / "img" / f"{number:04d}.jpg", number)
        lines.append(f"{OBJECTS[number % 3]},{'sd'[number % 2]},{','.join(map(str, row))},{number}")
    (folder / "all.csv").write_text("\n".join(lines))
    mapping = {
        "forces": "all.csv",
        "taxels": ["right", "left", "top"],
        "force_unit": "counts",
        "newtons_per_count": 0.01,
        "zero_count": 512,
        "object": "thing",
        "press": "how",
        "values": {"s": "shallow", "d": "deep"},
        "image": "img/{frame:04d}.*",
    }
    return folder, mapping, counts


@pytest.mark.parametrize("hold", [(0.0, 1.0), (0.5, 1.0)])
def test_files_of_one_press_are_averaged_over_their_hold(per_press, tmp_path, hold):
    folder, forces = per_press
    out = import_folder(folder, tmp_path / "set", mapping=Mapping(**PER_PRESS, hold=hold))
    assert check_dataset(out) == []
    dataset = Dataset.open(out)
    frame = dataset.columns()
    expected = [forces[name][int(6 * hold[0]) :].mean(axis=0) for name in frame["id"]]
    np.testing.assert_allclose(dataset.force(), expected, rtol=1e-6)
    assert list(frame["object"]) == [name.split("/")[1] for name in frame["id"]]
    assert list(frame["session"]) == [int(name.startswith("day-b")) for name in frame["id"]]
    assert "image_rest" in dataset.meta.columns


def test_counts_words_and_numbered_images(one_table, tmp_path):
    folder, mapping, counts = one_table
    dataset = Dataset.open(import_folder(folder, tmp_path / "set", mapping=Mapping(**mapping)))
    np.testing.assert_allclose(dataset.force(), (counts[:, [1, 0, 2]] - 512) * 0.01, rtol=1e-5)
    frame = dataset.columns()
    assert list(frame["id"]) == [f"img/{number:04d}.jpg" for number in range(6)]
    assert list(frame["press"]) == ["shallow", "deep"] * 3
    assert dataset.meta.source["mapping"]["zero_count"] == 512


@pytest.mark.parametrize("unit", NEWTONS)
def test_units_differ_by_their_newtons_alone(per_press, unit):
    folder, forces = per_press
    found = dry_run(folder, Mapping(**{**PER_PRESS, "force_unit": unit}))
    means = np.array([values.mean(axis=0) for values in forces.values()])
    np.testing.assert_allclose(
        found.counts["force_n"], [means.min() * 1e3 * NEWTONS[unit], means.max() * 1e3 * NEWTONS[unit]], atol=1e-4
    )


def test_npy_files_hold_what_csv_files_hold(per_press, tmp_path):
    folder, forces = per_press
    for name, samples in forces.items():
        np.save((folder / name).with_suffix(".npy"), samples * 1e3)
    both = []
    for kind in ("csv", "npy"):
        mapping = Mapping(**{**PER_PRESS, "forces": f"*/*/*.{kind}"})
        both.append(Dataset.open(import_folder(folder, tmp_path / kind, mapping=mapping)))
    np.testing.assert_allclose(both[0].force(), both[1].force(), rtol=1e-6)


def test_a_dry_run_says_what_is_there_and_writes_nothing(vtbench, per_press, tmp_path):
    folder, _ = per_press
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(PER_PRESS))
    before = sorted(tmp_path.rglob("*"))
    answer = vtbench("import", folder, "--mapping", tmp_path / "m.yaml", "--dry-run")
    assert answer.code == 0, answer.err
    for text in ("cup 4, nut 4, pen 4", "day-a 0, day-b 1", "12x16", "no problems; nothing was written"):
        assert text in answer.out
    assert sorted(tmp_path.rglob("*")) == before


def broken(line, old, new):
    def change(folder):
        path = folder / "day-a/nut/press_1.csv"
        lines = path.read_text().splitlines()
        lines[line - 1] = lines[line - 1].replace(old, new)
        path.write_text("\n".join(lines))

    return change


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            broken(
                4,
                ";",
                ";x",
            ),
            "nut/press_1.csv, line 4, column 'ch 1': expected a finite number, got 'x",
        ),
        (broken(5, ",", "."), None),
        (broken(2, "ch 10", "ch 3"), "nut/press_1.csv, line 2: column 'ch 3' is given twice"),
        (broken(2, ";ch 10", ""), "nut/press_1.csv, line 3: 5 cells, the heading has 4"),
        (lambda folder: (folder / "day-a/nut/press_1.png").unlink(), "nut/press_1.png: image cannot be read"),
        (lambda folder: picture(folder / "day-b/pen/press_0.png", 0, (12, 17)), "pen/press_0.png: image of 12x17"),
        (lambda folder: (folder / "day-b/rest.png").write_bytes(b""), "day-b/rest.png: not an image"),
    ],
)
def test_problems_have_their_file_line_and_column(per_press, tmp_path, change, message):
    folder, _ = per_press
    change(folder)
    found = dry_run(folder, Mapping(**PER_PRESS))
    if message is None:
        assert found.problems == []
        return
    assert any(message in problem for problem in found.problems), found.problems
    with pytest.raises(ValueError) as failure:  # noqa: PT011  the text is compared as it stands
        import_folder(folder, tmp_path / "set", mapping=Mapping(**PER_PRESS))
    assert "\n" not in str(failure.value)
    assert not (tmp_path / "set").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"taxels": "chan (.+)"}, "no column fits taxels: 'chan (.+)'; there are t, ch 1"),
        ({"taxels": ["ch 1", "ch 22"]}, "no column 'ch 22' of taxels; did you mean 'ch 2'"),
        ({"image": "{folder}/{stm}.png"}, "{stm} in a path of images is no column and no group; did you mean 'stem'?"),
        ({"delimiter": ","}, "delimiter and decimal are both ','"),
        ({"delimiter": ",", "decimal": "."}, "one column; are they parted by ';'?"),
        ({"decimal": "."}, "(decimal: ',' in the mapping?)"),
        ({"forces": "*/*.csv"}, "nothing fits '*/*.csv'"),
        ({"image": "../{stem}.png"}, "expected a path inside the folder"),
        ({"image": "{folder}/*.png"}, "expected one image that fits 'day-a/cup/*.png', found 2"),
        ({"forces_path": "(?P<object>"}, "not a regular expression"),
        ({"forces_path": "(?P<session>[^/]+)"}, "object: name its column, or a group (?P<object>...)"),
        ({"force_unit": "counts"}, "newtons_per_count goes with force_unit: counts"),
        ({"object": "t"}, "object: given by a column and by a group"),
        ({"hold": [0.5, 0.5]}, "hold: expected two fractions that grow"),
        ({"delimeter": ";"}, "delimeter: unknown key; did you mean 'delimiter'?"),
        ({"rest": None, "image": "{session}/rest.png"}, "day-a/rest.png: the image of 6 presses"),
    ],
)
def test_a_wrong_mapping_is_one_line(refused, per_press, tmp_path, change, message):
    folder, _ = per_press
    values = {key: value for key, value in {**PER_PRESS, **change}.items() if value is not None}
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(values))
    assert message in refused("import", folder, "--mapping", tmp_path / "m.yaml", "-o", tmp_path / "set")


def test_a_suggested_mapping_fits_the_folder_it_was_written_from(per_press, tmp_path):
    folder, _ = per_press
    (tmp_path / "m.yaml").write_text(suggest(folder))
    mapping = load_mapping(tmp_path / "m.yaml")
    found = dry_run(folder, mapping)
    assert found.problems == []
    assert (found.counts["presses"], found.counts["taxels"]) == (12, 4)
    assert found.counts["objects"] == dict.fromkeys(OBJECTS, 4)
    assert (mapping.skip_lines, mapping.delimiter, mapping.decimal) == (1, ";", ",")


@pytest.mark.parametrize("image", ["{frame}.png", "{frame}*"])
def test_a_cell_cannot_lead_out_of_the_folder(tmp_path, image):
    picture(tmp_path / "secret.png", 0)
    folder = tmp_path / "rec"
    folder.mkdir()
    (folder / "forces.csv").write_text("object,frame,f1\ncup,../secret,1\ncup,/etc/hostname,2\n")
    found = dry_run(folder, Mapping(object="object", image=image))
    assert len(found.problems) == 2
    for line, problem in enumerate(found.problems, start=2):
        assert f"line {line}: " in problem
        assert "lies outside the folder" in problem
