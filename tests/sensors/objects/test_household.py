import importlib

import numpy as np
import pytest

from sensors import objects
from sensors.objects import household
from sensors.objects.zbuffer import MeshSurface

NAMES = objects.names()


def footprint(name, pitch_mm=0.1):
    """Cell-centred samples over the declared box and 3 mm round it: x, y and heights in millimetres."""
    thing = objects.get(name)
    (cx, cy), (length, width, _) = thing.centre_mm, thing.size_mm
    x = np.arange(cx - length / 2 - 3.0, cx + length / 2 + 3.0, pitch_mm) + 0.5 * pitch_mm
    y = np.arange(cy - width / 2 - 3.0, cy + width / 2 + 3.0, pitch_mm) + 0.5 * pitch_mm
    return x, y, 1e3 * thing.height(1e-3 * x[None, :], 1e-3 * y[:, None])


def test_twenty_seven_objects_of_at_least_twelve_families():
    things = [objects.get(name) for name in NAMES]
    assert len(NAMES) == len(set(NAMES)) == 27
    assert len({thing.family for thing in things}) >= 12
    assert len({thing.title for thing in things}) == 27
    for thing in things:
        assert thing.name == thing.name.lower()
        assert " " not in thing.name
        assert "\n" not in thing.description
        assert thing.description.endswith(".")


def test_order_does_not_depend_on_how_often_or_where_the_shapes_are_imported():
    importlib.import_module("sensors.objects.shapes.walnut")
    assert objects.names() == NAMES
    families = [objects.get(name).family for name in NAMES]
    assert families[:2] == ["battery", "battery"]


@pytest.mark.parametrize("name", NAMES)
def test_object_is_finite_stands_on_the_table_and_has_its_declared_size(name):
    thing = objects.get(name)
    x, y, height = footprint(name)
    assert np.isfinite(height).all()
    assert height.min() == 0.0
    assert height.max() == pytest.approx(thing.size_mm[2], abs=0.12)
    columns, rows = x[(height > 0.0).any(axis=0)], y[(height > 0.0).any(axis=1)]
    for found, centre, size in zip((columns, rows), thing.centre_mm, thing.size_mm[:2], strict=True):
        assert np.ptp(found) + 0.1 == pytest.approx(size, abs=0.3)
        assert found.mean() == pytest.approx(centre, abs=2.0)
        assert 0.5 * (found[0] + found[-1]) == pytest.approx(centre, abs=0.2)


@pytest.mark.parametrize("name", NAMES)
def test_nothing_lies_outside_the_declared_box(name):
    thing = objects.get(name)
    x, y = np.meshgrid(np.linspace(-0.15, 0.15, 301), np.linspace(-0.15, 0.15, 301))
    outside = (np.abs(1e3 * x - thing.centre_mm[0]) > thing.size_mm[0] / 2 + 0.2) | (
        np.abs(1e3 * y - thing.centre_mm[1]) > thing.size_mm[1] / 2 + 0.2
    )
    assert not thing.height(x, y)[outside].any()


def test_meshes_lie_wholly_inside_the_box_they_are_rasterised_in():
    surfaces = {name: objects.get(name).surface for name in NAMES}
    meshes = {name: surface.build() for name, surface in surfaces.items() if isinstance(surface, MeshSurface)}
    assert len(meshes) >= 3
    for name, mesh in meshes.items():
        thing = objects.get(name)
        off = np.abs(mesh.vertices[:, :2] - thing.centre_mm) - 0.5 * np.asarray(thing.size_mm[:2])
        assert off.max() == pytest.approx(0.0, abs=0.08), name
        assert mesh.vertices[:, 2].max() <= thing.size_mm[2] + 1e-9


@pytest.mark.parametrize(
    ("name", "diameter_mm", "thickness_mm"),
    [("coin-1-euro", 23.25, 2.33), ("coin-2-euro", 25.75, 2.20), ("button", 23.0, 3.4)],
)
def test_discs_cover_the_area_of_their_diameter(name, diameter_mm, thickness_mm):
    _, _, height = footprint(name)
    holes = 4 * np.pi * 1.1**2 if name == "button" else 0.0
    assert (height > 0.0).sum() * 0.01 == pytest.approx(np.pi * diameter_mm**2 / 4 - holes, rel=2e-3)
    assert height.max() == pytest.approx(thickness_mm, abs=0.01)


@pytest.mark.parametrize(("name", "diameter_mm"), [("battery-aa", 14.5), ("battery-aaa", 10.5)])
def test_batteries_are_round_in_cross_section(name, diameter_mm):
    y = np.linspace(-0.49, 0.49, 99) * diameter_mm
    section = 1e3 * objects.get(name).height(0.0, 1e-3 * y)
    circle = diameter_mm / 2 + np.sqrt((diameter_mm / 2) ** 2 - y**2)
    assert np.abs(section - circle).max() < 0.1


def test_coin_relief_is_fine_texture():
    r = np.linspace(0.0, 10.0e-3, 200)
    angle = np.linspace(0.0, 2 * np.pi, 180)[:, None]
    face = objects.get("coin-2-euro").height(r * np.cos(angle), r * np.sin(angle))
    assert 0.05e-3 < np.ptp(face) < 0.5e-3


def test_the_bolts_thread_is_a_helix():
    """A step of one pitch along the axis changes nothing on the threaded length; a quarter step does."""
    bolt = objects.get("hex-bolt")
    x, y = np.meshgrid(np.linspace(-8e-3, 15e-3, 400), np.linspace(-3e-3, 3e-3, 31))
    assert bolt.height(x + 1.5e-3, y) == pytest.approx(bolt.height(x, y), abs=1e-9)
    assert np.abs(bolt.height(x + 0.375e-3, y) - bolt.height(x, y)).max() > 0.3e-3
    assert not np.allclose(bolt.height(x, y), bolt.height(x, -y), atol=1e-5)


@pytest.mark.parametrize(
    ("name", "turns"), [("toy-brick", 2), ("button", 4), ("cap-screw", 60), ("shaver", 3)], ids=str
)
def test_rotational_symmetry_where_the_thing_has_one(name, turns):
    """Equal after the turn but for steps that fall between samples, and clearly unlike after half of it."""
    x, y = np.meshgrid(np.linspace(-30e-3, 30e-3, 601), np.linspace(-30e-3, 30e-3, 601))
    height = objects.get(name).height

    def change(angle):
        c, s = np.cos(angle), np.sin(angle)
        return np.abs(height(x, y) - height(c * x - s * y, s * x + c * y)).mean()

    full_turn = 2 * np.pi / turns
    assert change(full_turn) < 0.1 * change(0.5 * full_turn)
    assert change(0.5 * full_turn) > 1e-6


def test_unknown_name_is_answered_with_the_nearest_one():
    with pytest.raises(ValueError, match=r"'batery-aa'.*did you mean 'battery-aa'"):
        objects.get("batery-aa")
    with pytest.raises(ValueError, match="vtbench list objects"):
        objects.get("zzz")


def test_a_name_is_given_once():
    with pytest.raises(ValueError, match="two household objects are called 'spoon'"):
        household.register("spoon", title="", family="", description="", size_mm=(1, 1, 1))(lambda x, y: x)
    assert objects.names() == NAMES


def test_unknown_attribute_of_the_package():
    with pytest.raises(AttributeError, match="no_such"):
        _ = objects.no_such
