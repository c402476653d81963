"""A folder of images and forces becomes a dataset, or one line says why it cannot."""

import csv

import cv2
import numpy as np
import pytest

from vtbench.data import Dataset, check_dataset, import_folder

TAXELS = [f"f{number}" for number in range(1, 17)]
NAMES = ("apple", "bolt", "cup")


def picture(number, height=20, width=30):
    return np.random.default_rng(number).integers(0, 256, (height, width, 3), dtype=np.uint8)


def lines(count=7):
    forces = np.random.default_rng(0).gamma(2.0, 0.5, (count, 16)).astype(np.float32)
    return [
        {
            "file": f"frames/{i}.png",
            "object": NAMES[i % 3],
            "press": "shallow" if i == 4 else "deep",
            "unit": i // 4,
            "rest_file": f"rest/{i}.bmp",
            "total_force_n": 5.0 + i,
            **dict(zip(TAXELS, map(float, force), strict=True)),
        }
        for i, force in enumerate(forces)
    ]


def fill(folder, rows, columns=None):
    for name in ("frames", "rest"):
        (folder / name).mkdir(parents=True)
    for number in range(len(rows)):
        cv2.imwrite(str(folder / f"frames/{number}.png"), picture(number)[..., ::-1])
        cv2.imwrite(str(folder / f"rest/{number}.bmp"), picture(100 + number)[..., ::-1])
    with (folder / "forces.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, columns or list(rows[0]), extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    return folder


def test_what_was_recorded_is_what_is_read(tmp_path):
    rows = lines()
    out = import_folder(fill(tmp_path / "mine", rows), tmp_path / "set", samples_per_shard=3)
    assert check_dataset(out) == []
    dataset = Dataset.open(out)
    assert (dataset.n, dataset.classes, dataset.meta.kind, dataset.meta.name) == (
        7,
        list(NAMES),
        "imported",
        "mine",
    )
    np.testing.assert_array_equal(dataset.images(), [picture(i) for i in range(7)])
    np.testing.assert_array_equal(dataset.images(column="image_rest"), [picture(100 + i) for i in range(7)])
    np.testing.assert_array_equal(dataset.force(), np.array([[row[f] for f in TAXELS] for row in rows], "f4"))
    frame = dataset.columns()
    for column in ("object", "press", "unit", "total_force_n"):
        assert list(frame[column]) == [row[column] for row in rows]
    assert list(frame["round"]) == [0, 0, 0, 1, 1, 1, 2]
    assert list(frame["session"]) == [0] * 7
    summary = dataset.summary()
    assert summary["presses"] == {"deep": 6, "shallow": 1}
    assert (summary["samples"], summary["objects"], summary["units"], summary["sessions"]) == (7, 3, 2, 2)


def test_the_smallest_folder_has_three_kinds_of_columns(tmp_path):
    rows = lines(3)
    out = import_folder(fill(tmp_path / "mine", rows, ["file", "object", "f1", "f2"]), tmp_path / "set")
    dataset = Dataset.open(out)
    assert dataset.meta.n_taxels == 2
    assert set(dataset.columns()["press"]) == {"deep"}
    with pytest.raises(ValueError, match="no column 'image_rest'"):
        dataset.images(column="image_rest")


def test_importing_twice_changes_nothing_and_other_recordings_are_refused(tmp_path):
    rows = lines()
    folder = fill(tmp_path / "mine", rows)
    out = import_folder(folder, tmp_path / "set")
    before = {path: path.stat().st_mtime_ns for path in out.iterdir()}
    import_folder(folder, out)
    cv2.imwrite(str(folder / "frames/2.png"), picture(55))
    with pytest.raises(ValueError, match="holds another dataset"):
        import_folder(folder, out)
    assert {path: path.stat().st_mtime_ns for path in out.iterdir()} == before


def test_grey_images_become_three_equal_channels(tmp_path):
    folder = fill(tmp_path / "mine", lines(2))
    cv2.imwrite(str(folder / "frames/1.png"), picture(1)[..., 0])
    image = Dataset.open(import_folder(folder, tmp_path / "set")).images([1])[0]
    np.testing.assert_array_equal(image, np.repeat(picture(1)[..., :1], 3, axis=2))


def no(key):
    return lambda rows: [{k: v for k, v in row.items() if k != key} for row in rows]


def cell(column, value, row=3):
    return lambda rows: [{**r, column: value} if i == row else r for i, r in enumerate(rows)]


def renamed(old, new):
    return lambda rows: [{new if k == old else k: v for k, v in row.items()} for row in rows]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (cell("f7", "nan"), "line 5, column 'f7': expected a finite number of newtons, got 'nan'"),
        (cell("f7", "-1e39"), "line 5, column 'f7': expected a finite number of newtons, got '-1e39'"),
        (cell("total_force_n", "1e999"), "line 5, column 'total_force_n': expected a finite number of newtons"),
        (cell("f7", ""), "line 5, column 'f7': expected a finite number of newtons, got ''"),
        (cell("f7", "1,5"), "line 5, column 'f7': expected a finite number"),
        (no("f9"), "expected the force columns f1, f2, ... without a gap, got f1, f2"),
        (no("object"), "column 'object' is missing; there are file, press"),
        (renamed("unit", "unti"), "unknown column 'unti'; did you mean 'unit'?"),
        (cell("object", " "), "line 5, column 'object': expected a value"),
        (cell("press", "hard"), "line 5, column 'press': expected one of deep, shallow, got 'hard'"),
        (cell("unit", "-1"), "line 5, column 'unit': expected a whole number, 0 or more, got '-1'"),
        (cell("file", "frames/0.png"), "line 5, column 'file': an earlier line names it already"),
        (cell("file", "frames/77.png"), r"frames/77.png: image cannot be read (No such file or directory)"),
        (cell("file", "../../x.png"), "'../../x.png' lies outside this folder"),
        (cell("file", "forces.csv"), "forces.csv: not an image that OpenCV can read"),
    ],
)
def test_a_bad_csv_is_named_and_nothing_is_written(tmp_path, change, message):
    folder = fill(tmp_path / "mine", change(lines()))
    with pytest.raises(ValueError) as failure:  # noqa: PT011  the text is compared as it stands
        import_folder(folder, tmp_path / "set")
    assert message in str(failure.value)
    assert "\n" not in str(failure.value)
    assert not (tmp_path / "set").exists()


def test_columns_parted_by_semicolons_are_called_that(tmp_path):
    folder = fill(tmp_path / "mine", lines())
    path = folder / "forces.csv"
    path.write_text(path.read_text().replace(",", ";"))
    with pytest.raises(ValueError, match="expected columns parted by commas, got ';'"):
        import_folder(folder, tmp_path / "set")


def test_a_line_of_fifteen_forces_is_named(tmp_path):
    folder = fill(tmp_path / "mine", lines())
    text = (folder / "forces.csv").read_text().splitlines()
    text[3] = text[3].rpartition(",")[0]
    (folder / "forces.csv").write_text("\n".join(text))
    with pytest.raises(ValueError, match=r"line 4: 21 cells, the heading has 22 \(15 forces for 16 taxels\?\)"):
        import_folder(folder, tmp_path / "set")


def test_an_image_of_another_size_is_named(tmp_path):
    folder = fill(tmp_path / "mine", lines())
    cv2.imwrite(str(folder / "rest/5.bmp"), picture(5, width=31))
    message = r"rest/5.bmp: image of 20x31 pixels, frames/0.png has 20x30 .* all images must have one size"
    with pytest.raises(ValueError, match=message):
        import_folder(folder, tmp_path / "set")
    assert not (tmp_path / "set").exists()


def test_sixteen_bit_images_are_refused(tmp_path):
    folder = fill(tmp_path / "mine", lines())
    cv2.imwrite(str(folder / "frames/0.png"), picture(0).astype(np.uint16))
    with pytest.raises(ValueError, match=r"frames/0.png: uint16 pixels; expected 8 bits"):
        import_folder(folder, tmp_path / "set")


@pytest.mark.parametrize("text", [None, "", "file,object,f1\n"])
def test_without_presses_nothing_is_imported(tmp_path, text):
    if text is not None:
        (tmp_path / "forces.csv").write_text(text)
    with pytest.raises(ValueError, match=r"forces.csv: no (such file|presses)"):
        import_folder(tmp_path, tmp_path / "set")
