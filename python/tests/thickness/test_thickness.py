"""Thickness models and maps: the power law, sampling, refusals."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import iridesce as ir

RNG = np.random.default_rng(11)


def test_the_power_law():
    model = ir.thickness.gradient(top=20.0, bottom=900.0, exponent=0.8)
    s = np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(model.at_height(s), 900.0 + (20.0 - 900.0) * s**0.8, rtol=1e-14)
    assert model.at_height(s.reshape(1, 101, 1)).shape == (1, 101, 1)
    assert isinstance(model.at_height(0.5), float)
    assert model.at_height([]).shape == (0,)
    assert (model.at_height(-1.0), model.at_height(2.0)) == (900.0, 20.0), "clamped"
    backwards = s[::-1]
    np.testing.assert_array_equal(model.at_height(backwards), model.at_height(s)[::-1])
    np.testing.assert_array_equal(ir.thickness.uniform(320.0).at_height(s), 320.0)


def test_a_map_has_the_model_at_the_middles_of_its_cells():
    model = ir.thickness.gradient(100.0, 900.0, 2.0)
    grid = model.map(3, 5)
    assert (grid.width, grid.height, grid.thickness_nm.shape, grid.thickness_nm.dtype) == (3, 5, (5, 3), np.float64)
    for row in range(5):
        np.testing.assert_allclose(grid.thickness_nm[row], model.at_height(1.0 - (row + 0.5) / 5), rtol=1e-15)
    assert not grid.thickness_nm.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        grid.thickness_nm[0, 0] = 1.0


def test_sampling_is_bilinear():
    values = RNG.uniform(0.0, 1000.0, (7, 4))
    grid = ir.thickness.ThicknessMap(values)
    v, u = np.mgrid[0:7, 0:4]
    np.testing.assert_allclose(grid.sample((u + 0.5) / 4, 1.0 - (v + 0.5) / 7), values, rtol=1e-12)
    # Between middles: against weights written out.
    x, y = RNG.uniform(0.0, 3.0, 50), RNG.uniform(0.0, 6.0, 50)
    i, j = x.astype(int), y.astype(int)
    fx, fy = x - i, y - j
    expected = (
        values[j, i] * (1 - fx) * (1 - fy)
        + values[j, i + 1] * fx * (1 - fy)
        + values[j + 1, i] * (1 - fx) * fy
        + values[j + 1, i + 1] * fx * fy
    )
    np.testing.assert_allclose(grid.sample((x + 0.5) / 4, 1.0 - (y + 0.5) / 7), expected, rtol=1e-12)
    assert grid.sample(-3.0, 2.0) == values[0, 0]
    assert grid.sample(np.zeros((2, 1)), np.zeros(3)).shape == (2, 3)
    assert isinstance(grid.sample(0.5, 0.5), float)


def test_maps_take_any_array_and_keep_their_own():
    values = np.asfortranarray(np.arange(12, dtype=np.float32).reshape(3, 4))[:, ::-1]
    values.flags.writeable = False
    grid = ir.thickness.ThicknessMap(values)
    np.testing.assert_array_equal(grid, values)
    own = np.ones((2, 2))
    grid = ir.thickness.ThicknessMap(own)
    own[:] = 5.0
    assert grid.thickness_nm.max() == 1.0
    assert np.array(grid, copy=True).flags.writeable
    assert ir.thickness.ThicknessMap([[1, 2]]).thickness_nm.tolist() == [[1.0, 2.0]]


def test_maps_and_models_are_values():
    grid, model = ir.thickness.gradient(1.0, 2.0).map(2, 2), ir.thickness.gradient(1.0, 2.0)
    assert grid == ir.thickness.gradient(1.0, 2.0).map(2, 2)
    assert grid != ir.thickness.uniform(1.0).map(2, 2)
    assert model == ir.thickness.gradient(1, 2, exponent=1)
    assert model != ir.thickness.gradient(1, 2, exponent=2)
    assert model != ir.thickness.uniform(1.0)
    for value in (grid, model, ir.thickness.uniform(3.5)):
        again = pickle.loads(pickle.dumps(value))
        assert again == value
        assert hash(again) == hash(value)
        assert repr(again) == repr(value)
    assert eval(repr(model), vars(ir.thickness)) == model


def test_a_map_colours_a_film():
    grid = ir.thickness.gradient(100.0, 700.0).map(2, 5)
    colors = ir.Stack(["air", ir.Layer("soap", thickness_nm=grid), "air"]).color()
    assert colors.shape == (5, 2, 3)
    one = ir.Stack(["air", ir.Layer("soap", thickness_nm=float(grid.thickness_nm[3, 1])), "air"]).color()
    np.testing.assert_allclose(colors[3, 1], one, rtol=1e-12)


def test_a_map_has_a_picture_and_a_plot():
    grid = ir.thickness.ThicknessMap([[0.0, 100.0, 250.0], [300.0, 400.0, 500.0]])
    film = ir.Stack(["air", ir.Layer("soap", thickness_nm=grid.thickness_nm), "air"])
    assert np.array_equal(grid.color(), film.color(space="srgb"))
    assert np.array_equal(grid.color("MgF2", "water", space="lab", angle_deg=30.0), ir.Stack(
        ["air", ir.Layer("MgF2", thickness_nm=grid.thickness_nm), "water"]).color(space="lab", angle_deg=30.0))  # fmt: skip
    ax = grid.plot(title="")
    assert ax.get_title() == "" and np.array_equal(ax.get_images()[0].get_array(), grid.thickness_nm)
    assert grid.plot(ax).get_title() == "0 to 500 nm"


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0, "3", b"3", None, [1.0], 1j, True, 10**400])
def test_bad_parameters_are_named(bad):
    with pytest.raises(ValueError, match="thickness_nm must be"):
        ir.thickness.uniform(bad)
    with pytest.raises(ValueError, match="top must be"):
        ir.thickness.gradient(bad, 1.0)
    with pytest.raises(ValueError, match="bottom must be"):
        ir.thickness.gradient(1.0, bad)
    with pytest.raises(ValueError, match="exponent must be"):
        ir.thickness.gradient(1.0, 1.0, bad)


def test_an_exponent_of_zero_is_refused():
    with pytest.raises(ValueError, match=r"exponent must be > 0 and finite, got 0\.0"):
        ir.thickness.gradient(1.0, 2.0, 0.0)


def test_bad_coordinates_are_named_with_their_place():
    model = ir.thickness.gradient(1.0, 2.0)
    with pytest.raises(ValueError, match=r"s must be finite, got nan at index \(1, 0\)"):
        model.at_height([[0.0, 1.0], [math.nan, 1.0]])
    with pytest.raises(ValueError, match=r"s must be finite, got inf$"):
        model.at_height(math.inf)
    for bad in ("0.5", [None], 1j, [[0.0], [0.0, 1.0]]):
        with pytest.raises(ValueError, match="s must be real numbers"):
            model.at_height(bad)
    grid = model.map(2, 2)
    with pytest.raises(ValueError, match=r"v must be finite, got nan at index \(1,\)"):
        grid.sample(0.0, [0.0, math.nan])
    with pytest.raises(ValueError, match=r"u and v must broadcast: shapes \(2,\) and \(3,\)"):
        grid.sample([0.0, 1.0], [0.0, 1.0, 0.5])


@pytest.mark.parametrize("size", [(0, 1), (1, 0), (-1, 1), (1.5, 1), ("2", 1), (None, 1), (math.nan, 1)])
def test_bad_sizes(size):
    with pytest.raises(ValueError, match="must be a whole number >= 1"):
        ir.thickness.uniform(1.0).map(*size)


def test_a_map_that_cannot_fit():
    with pytest.raises(ir.ResourceError, match="1073741824 cells"):
        ir.thickness.uniform(1.0).map(10**6, 10**6)
    with pytest.raises(ir.ResourceError):
        ir.thickness.uniform(1.0).map(2**70, 2**70)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (3.0, r"shape \(height, width\), both >= 1, got \(\)"),
        ([1.0, 2.0], r"got \(2,\)"),
        (np.zeros((2, 0)), r"got \(2, 0\)"),
        (np.zeros((2, 2, 2)), r"got \(2, 2, 2\)"),
        ([[1.0, math.nan]], "at row 0, column 1"),
        ([[1.0], [-2.0]], r"got -2\.0 at row 1, column 0"),
        ([[1.0, math.inf]], "at row 0, column 1"),
        ([["a"]], "must be real numbers"),
        ([[1j]], "must be real numbers"),
        (None, "must be real numbers"),
    ],
)
def test_bad_maps(values, said):
    with pytest.raises(ValueError, match=said):
        ir.thickness.ThicknessMap(values)


def test_the_renderer_sees_the_same_thickness():
    """The plane `thickness_nm` of a picture is the model at the height of what is seen there."""
    model = ir.thickness.gradient(100.0, 900.0, 0.6)
    tree = {
        "version": 1,
        "camera": {"orthographic_height": 2.0, "resolution": [65, 65]},
        "object": [{"shape": {"sphere": {"radius": 1.0}}, "surface": {"film": {"thickness_nm": model}}}],
        "light": [{"environment": {"illuminant": "E"}}],
    }
    column = ir.render(tree, samples=1).channels["thickness_nm"][1:-1, 32]
    # One sample somewhere in each pixel: between the thicknesses at its upper and lower edge, up to single precision.
    edges = 1.0 - np.arange(66) / 65
    thin, thick = model.at_height(edges[1:-2]), model.at_height(edges[2:-1])
    assert (column > thin - 0.01).all()
    assert (column < thick + 0.01).all()


# --- wedges and gaps


def test_a_wedge_is_linear_along_its_way_and_holds_beyond():
    start, end = np.array([1.0, -2.0, 0.5]), np.array([-3.0, 4.0, 2.0])
    model = ir.thickness.wedge(start, end, 50.0, 650.0)
    share = np.linspace(-1.0, 2.0, 31)
    sideways = np.cross(end - start, [0.3, 1.0, -0.2])
    points = start + share[:, None] * (end - start) + RNG.normal(size=(31, 1)) * sideways
    np.testing.assert_allclose(model.at_point(points), 50.0 + 600.0 * np.clip(share, 0.0, 1.0), rtol=1e-12)
    assert isinstance(model.at_point(start), float)
    assert model.at_point(points.reshape(31, 1, 3)).shape == (31, 1)
    assert model.at_point(np.zeros((0, 3))).shape == (0,)
    grid = ir.thickness.wedge([0, 0, 0], [4, 0, 0], 0.0, 400.0).map(4, 2, extent=(0.0, 4.0, -1.0, 1.0))
    np.testing.assert_allclose(grid.thickness_nm, [[50.0, 150.0, 250.0, 350.0]] * 2)


def test_a_gap_is_that_under_a_sphere():
    from decimal import Decimal, getcontext

    getcontext().prec = 50
    for radius in (0.5, 1000.0, 123456.0):
        model = ir.thickness.lens_gap(radius, contact_gap_nm=7.0)
        for share in (0.0, 1e-7, 1e-3, 0.02, 0.5, 0.999, 1.0):
            r = share * radius
            big, small = Decimal(radius), Decimal(r)
            exact = Decimal(7) + Decimal(10) ** 6 * (big - (big * big - small * small).sqrt())
            # sqrt(R^2 - r^2) near r = R: a rounding of r moves the gap by far more than itself.
            assert model.at_radius(r) == pytest.approx(float(exact), rel=1e-12 if share < 0.9 else 1e-6)
        assert model.at_radius(3.0 * radius) == model.at_radius(radius)
    m = np.arange(1, 11)
    t = ir.thickness.lens_gap(1000.0).at_radius(np.sqrt(m * 589.3e-6 * 1000.0))
    np.testing.assert_allclose(t, m * 589.3 / 2, rtol=3e-6)


def test_models_are_asked_what_they_follow():
    gap, wedge = ir.thickness.lens_gap(1000.0), ir.thickness.wedge([0, 0, 0], [1, 0, 0], 0, 1)
    uniform = ir.thickness.uniform(5.0)
    assert uniform.at_point([1.0, 2.0, 3.0]) == uniform.at_radius(3.0) == uniform.at_height(0.1) == 5.0
    for model, method, hint in [
        (gap, "at_height", "a lens_gap is not asked by at_height; use at_radius"),
        (wedge, "at_radius", "use at_point"),
        (ir.thickness.gradient(0, 1), "at_point", "use at_height"),
        (ir.thickness.map("x.npy"), "at_height", "use map"),
    ]:
        with pytest.raises(ValueError, match=hint):
            getattr(model, method)([0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"last axis of 3 coordinates, got the shape \(2,\)"):
        wedge.at_point([1.0, 2.0])
    with pytest.raises(ValueError, match=r"distance_mm must be >= 0, got -1\.0 at index \(1,\)"):
        gap.at_radius([0.0, -1.0])
    for extent, said in [
        (None, "extent must be the part"),
        ((0, 1, 0), "extent must be left"),
        ((0, 0, 0, 1), "with an area"),
        ((0, math.nan, 0, 1), "four finite numbers"),
        ("abcd", "real numbers"),
    ]:
        for model in (gap, wedge):
            with pytest.raises(ValueError, match=said):
                model.map(2, 2, extent=extent)
    for model in (uniform, ir.thickness.gradient(0, 1), ir.thickness.map("x.npy")):
        with pytest.raises(ValueError, match="extent is for a wedge or a gap"):
            model.map(2, 2, extent=(0, 1, 0, 1))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0, "3", None, [1.0], 1j, True])
def test_bad_parameters_of_wedges_gaps_and_maps_are_named(bad):
    a, b = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="radius_mm must be"):
        ir.thickness.lens_gap(bad)
    with pytest.raises(ValueError, match="contact_gap_nm must be"):
        ir.thickness.lens_gap(1000.0, bad)
    with pytest.raises(ValueError, match="start_nm must be"):
        ir.thickness.wedge(a, b, bad, 1.0)
    with pytest.raises(ValueError, match="end_nm must be"):
        ir.thickness.wedge(a, b, 1.0, bad)
    with pytest.raises(ValueError, match="from_point must be"):
        ir.thickness.wedge(bad, b, 0.0, 1.0)
    with pytest.raises(ValueError, match="to_point must be"):
        ir.thickness.wedge(a, (bad, 0.0, 0.0) if isinstance(bad, float) and not math.isfinite(bad) else bad, 0.0, 1.0)
    if bad is not None:
        with pytest.raises(ValueError, match="max_nm must be"):
            ir.thickness.map("x.png", 0.0, bad)
    with pytest.raises(ValueError, match="path must be a file name"):
        ir.thickness.map(None if isinstance(bad, str) else bad)


def test_a_wedge_needs_two_points():
    with pytest.raises(ValueError, match=r"to_point must be a point away from the other end \[1\.0, 2\.0, 3\.0\]"):
        ir.thickness.wedge([1, 2, 3], [1, 2, 3], 0.0, 1.0)


@pytest.mark.parametrize(
    "model",
    [
        ir.thickness.wedge((0.0, 1.0, 2.0), np.array([3, 4, 5]), 0.0, 800),
        ir.thickness.lens_gap(1000, contact_gap_nm=5),
        ir.thickness.map("maps/film.png", min_nm=0, max_nm=500.0),
        ir.thickness.map("film.tif"),
    ],
)
def test_new_models_are_values(model):
    again = pickle.loads(pickle.dumps(model))
    assert again == model
    assert hash(again) == hash(model)
    assert eval(repr(model), vars(ir.thickness)) == model
    assert model != ir.thickness.uniform(1.0)


def test_models_go_into_scenes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ir.thickness.gradient(0.0, 500.0).map(4, 8).save("film.npy")
    scene = ir.Scene.load({"version": 1, "camera": {}, "object": [{"shape": {"disk": {}}, "surface": {"film": {
        "thickness_nm": 5.0}}}], "light": [{"environment": {"illuminant": "D65"}}]})  # fmt: skip
    for model in (
        ir.thickness.wedge([0, 0, 0], [4, 0, 0], 0.0, 800.0),
        ir.thickness.lens_gap(1000.0),
        ir.thickness.map("film.npy"),
    ):
        changed = scene.with_value("object.bubble.surface.film.thickness_nm", model)
        written = changed.to_dict()["object"][0]["surface"]["film"]["thickness_nm"]
        assert written == model.to_scene()
        assert ir.Scene.load(changed.to_dict()) == changed


# --- files


def test_maps_come_back_from_their_files(tmp_path):
    values = RNG.uniform(0.0, 2000.0, (5, 3)).astype(np.float32)
    grid = ir.thickness.ThicknessMap(values)
    for name in ("a.tif", "a.TIFF", "a.exr", "a.npy"):
        grid.save(tmp_path / name)
        assert ir.thickness.ThicknessMap.load(tmp_path / name) == grid, name
    # Doubles keep their digits in NPY, and are rounded once elsewhere.
    fine = ir.thickness.ThicknessMap([[1.0 / 3.0]])
    for name, expected in (("b.npy", 1.0 / 3.0), ("b.tif", float(np.float32(1.0 / 3.0)))):
        fine.save(tmp_path / name)
        assert ir.thickness.ThicknessMap.load(tmp_path / name).thickness_nm[0, 0] == expected
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.TIFF", "a.exr", "a.npy", "a.tif", "b.npy", "b.tif"]


def test_imagej_finds_the_units(tmp_path):
    """ImageJ reads `vunit` of a 32-bit picture as the unit of its values, `unit` and the resolution as its scale."""
    import tifffile

    grid = ir.thickness.gradient(100.0, 900.0).map(3, 4)
    grid.save(tmp_path / "film.tif", pixel_size=(0.5, 0.25), unit="um")
    with tifffile.TiffFile(tmp_path / "film.tif") as file:
        page, facts = file.pages[0], file.imagej_metadata
        assert file.is_imagej
        assert page.description.startswith("ImageJ=")
        assert (facts["vunit"], facts["unit"]) == ("nm", "um")
        assert (facts["min"], facts["max"]) == (200.0, 800.0)
        assert (page.shape, page.dtype, page.samplesperpixel) == ((4, 3), np.float32, 1)
        assert page.resolution == (2.0, 4.0)
        assert page.resolutionunit == 1, "the unit is the one that ImageJ names"
        np.testing.assert_array_equal(page.asarray(), grid.thickness_nm.astype(np.float32))
    grid.save(tmp_path / "plain.tif")
    with tifffile.TiffFile(tmp_path / "plain.tif") as file:
        assert "unit" not in file.imagej_metadata
        assert file.imagej_metadata["vunit"] == "nm"
    first = (tmp_path / "plain.tif").read_bytes()
    grid.save(tmp_path / "plain.tif")
    assert (tmp_path / "plain.tif").read_bytes() == first


def test_a_map_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    import tifffile

    grid = ir.thickness.uniform(5.0).map(2, 2)
    file = tmp_path / "film.tif"
    file.write_text("old")

    def breaks(*_args, **_kwargs):
        raise OSError("the disk is full")

    monkeypatch.setattr(tifffile, "imwrite", breaks)
    with pytest.raises(OSError, match="the disk is full"):
        grid.save(file)
    assert file.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["film.tif"]
    monkeypatch.undo()
    grid.save(file)
    assert ir.thickness.ThicknessMap.load(file) == grid
    (tmp_path / "folder.npy").mkdir()
    with pytest.raises(IsADirectoryError):
        grid.save(tmp_path / "folder.npy")
    with pytest.raises(FileNotFoundError):
        grid.save(tmp_path / "none" / "film.exr")


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("film.png", {}, r"path must end in \.tif, \.tiff, \.exr, \.npy"),
        ("film", {}, "path must end in"),
        ("film.exr", {"pixel_size": 1.0}, "pixel_size goes with a TIFF file"),
        ("film.tif", {"pixel_size": 0.0}, "pixel_size must be"),
        ("film.tif", {"pixel_size": (1.0, 2.0, 3.0)}, "pixel_size must be"),
        ("film.tif", {"pixel_size": "1"}, "pixel_size must be"),
        ("film.tif", {"pixel_size": math.nan}, "pixel_size must be"),
        ("film.tif", {"pixel_size": 1.0, "unit": "\n"}, "unit must be"),
        ("film.tif", {"pixel_size": 1.0, "unit": None}, "unit must be"),
    ],
)
def test_bad_saves(tmp_path, name, options, said):
    with pytest.raises(ValueError, match=said):
        ir.thickness.uniform(5.0).map(2, 2).save(tmp_path / name, **options)
    assert list(tmp_path.iterdir()) == []


def test_a_thickness_beyond_single_precision(tmp_path):
    grid = ir.thickness.ThicknessMap([[1e39]])
    for name in ("film.tif", "film.exr"):
        with pytest.raises(ValueError, match="does not fit single precision"):
            grid.save(tmp_path / name)
    grid.save(tmp_path / "film.npy")
    assert ir.thickness.ThicknessMap.load(tmp_path / "film.npy") == grid


WHOLE = np.array([[0, 51, 102], [153, 204, 255]], dtype=np.uint8)


def whole_numbers(folder):
    """Files of 8 and 16 bits, written by other programs."""
    import matplotlib.image
    import tifffile

    np.save(folder / "a.npy", WHOLE)
    np.save(folder / "b.npy", np.asfortranarray(WHOLE.astype(">u2") * 257))
    tifffile.imwrite(folder / "a.tif", WHOLE)
    tifffile.imwrite(folder / "b.tif", WHOLE.astype(np.uint16) * 257, compression="zlib", byteorder=">")
    matplotlib.image.imsave(folder / "a.png", np.repeat(WHOLE[..., None], 3, axis=2))
    return sorted(folder.iterdir())


def test_whole_numbers_are_a_range(tmp_path):
    files = whole_numbers(tmp_path)
    assert len(files) == 5
    for file in files:
        grid = ir.thickness.ThicknessMap.load(file, min_nm=100, max_nm=np.float32(600.0))
        np.testing.assert_allclose(grid.thickness_nm, [[100, 200, 300], [400, 500, 600]], rtol=1e-12, err_msg=file.name)
        for options, key in [({}, "min_nm"), ({"min_nm": 0.0}, "max_nm"), ({"min_nm": 9, "max_nm": 3}, "max_nm")]:
            with pytest.raises(ValueError, match=f"^{key} "):
                ir.thickness.ThicknessMap.load(file, **options)


def test_floats_are_nanometres(tmp_path):
    import tifffile

    values = RNG.uniform(0.0, 2000.0, (4, 6))
    half = values.astype(np.float16)
    np.save(tmp_path / "half.npy", half)
    np.save(tmp_path / "double.npy", np.asfortranarray(values))
    tifffile.imwrite(tmp_path / "double.tif", values, tile=(16, 16), compression="zlib")
    for name, expected in (("half.npy", half), ("double.npy", values), ("double.tif", values)):
        np.testing.assert_array_equal(ir.thickness.ThicknessMap.load(tmp_path / name).thickness_nm, expected)
        with pytest.raises(ValueError, match=r"^max_nm must be left out"):
            ir.thickness.ThicknessMap.load(tmp_path / name, max_nm=5.0)


def test_a_map_model_resamples_its_file(tmp_path):
    grid = ir.thickness.ThicknessMap(RNG.uniform(0.0, 900.0, (3, 5)))
    grid.save(tmp_path / "film.npy")
    model = ir.thickness.map(tmp_path / "film.npy")
    np.testing.assert_allclose(model.map(5, 3).thickness_nm, grid.thickness_nm, rtol=1e-12)
    assert model.map(1, 1).thickness_nm[0, 0] == pytest.approx(grid.sample(0.5, 0.5))
    with pytest.raises(ValueError, match="there is no such file"):
        ir.thickness.map(tmp_path / "none.npy").map(2, 2)


def test_bad_files_are_named(tmp_path):
    bad = tmp_path / "film.npy"
    for content, said in [
        (b"", "it is empty"),
        (b"hello", "it is no OpenEXR, TIFF, PNG or NPY file"),
        (b"\x93NUMPY\x01\x00\xff\xff", "damaged NPY"),
        (b"\x89PNG\r\n\x1a\n", "damaged or unsupported PNG"),
        (b"II*\x00\xff\xff\xff\xff", "damaged or unsupported TIFF"),
        (b"\x76\x2f\x31\x01" + bytes(100), "damaged or unsupported OpenEXR"),
    ]:
        bad.write_bytes(content)
        with pytest.raises(ValueError, match=f"film.npy.*cannot be used as a thickness map: {said}"):
            ir.thickness.ThicknessMap.load(bad)
    for values, said in [
        (np.zeros(3), "two sides"),
        (np.zeros((2, 0)), "no pixels"),
        (np.array([[1.0, -2.0]]), "it holds -2 at row 0, column 1"),
        (np.array([[1.0], [np.inf]]), "it holds inf at row 1, column 0"),
        (np.zeros((2, 2), dtype=np.int32), "its numbers are of type"),
        (np.zeros((2, 2), dtype=complex), "its numbers are of type"),
    ]:
        np.save(bad, values)
        with pytest.raises(ValueError, match=said):
            ir.thickness.ThicknessMap.load(bad)
    with pytest.raises(ValueError, match="it is a folder"):
        ir.thickness.ThicknessMap.load(tmp_path)
    for path in (None, 3, "", "a\0b"):
        with pytest.raises(ValueError, match="path must be a file name"):
            ir.thickness.ThicknessMap.load(path)
