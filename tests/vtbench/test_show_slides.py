"""Pictures of slides: one trial of each kind, and one trial with its scores."""

import cv2
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

from tests.vtbench.data.fake_slides import FakeSlipScene, simulate
from vtbench.data.slide_writer import write_slides
from vtbench.show import show


@pytest.fixture(scope="module")
def slides(tmp_path_factory):
    out = tmp_path_factory.mktemp("slides") / "set"
    return write_slides(out, FakeSlipScene(period=4), simulate=simulate, progress=False)


def colour_share(png, rgb):
    image = cv2.imread(str(png))[..., ::-1].astype(int)
    return float((np.abs(image - np.array(rgb)).max(-1) < 6).mean())


GROSS_ON_PAPER = (247, 214, 205)
"""The state's colour at 55 % over the page."""


def test_a_sheet_shows_every_kind_and_shades_the_slip(slides, tmp_path):
    png = show(slides, tmp_path / "sheet.png")
    assert colour_share(png, GROSS_ON_PAPER) > 0.01


def test_one_trial_stands_with_its_scores_and_thresholds(slides, tmp_path):
    with_slip = show(slides, tmp_path / "slip.png", sample=0)
    without = show(slides, tmp_path / "quiet.png", sample=11)
    assert colour_share(with_slip, GROSS_ON_PAPER) > 0.05
    assert colour_share(without, GROSS_ON_PAPER) < 1e-4
    for png in (with_slip, without):
        assert colour_share(png, (166, 61, 109)) > 0.00005  # beta


def told(monkeypatch, png, dataset, **more):
    """Everything written on the page of a picture."""
    pages = []
    saved = Figure.savefig
    monkeypatch.setattr(
        Figure, "savefig", lambda page, *given, **named: pages.append(page) or saved(page, *given, **named)
    )
    show(dataset, png, **more)
    return " | ".join(text.get_text() for text in pages[0].findobj(Text))


def test_a_trial_explains_what_it_draws_and_nothing_else(slides, tmp_path, monkeypatch):
    alone = write_slides(tmp_path / "one", FakeSlipScene(n_samples=1), simulate=simulate, progress=False)
    slip = told(monkeypatch, tmp_path / "a.png", slides, sample=0)
    assert all(word in slip for word in ("red: gross slip", "dashed: onset", "bar: alarm", "β from", "other taxels"))
    quiet = told(monkeypatch, tmp_path / "b.png", slides, sample=11)
    assert "bar: alarm" in quiet
    assert not any(word in quiet for word in ("partial slip", "gross slip", "onset"))
    single = told(monkeypatch, tmp_path / "c.png", alone, sample=0)
    assert "no β: no other sample slips" in single
    assert "bar: alarm" not in single


def test_a_trial_that_is_not_there_is_named(slides, tmp_path):
    with pytest.raises(ValueError, match="no sample 12, there are 12"):
        show(slides, tmp_path / "x.png", sample=12)
