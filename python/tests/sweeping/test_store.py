"""The folder of a sweep: what it refuses, what it makes again, and that nothing else is needed to go on."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from iridesce.sweeping.needed import lay_out, needed_files

SOAP = "air / soap 320 / air"
NM = "layers.0.thickness_nm"
VARY = {NM: [100.0, 200.0, 300.0, 400.0]}


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "points").iterdir()}


def test_a_store_holds_exr_npy_and_json_alone(tmp_path: Path) -> None:
    scene = ir.Scene.load("soap-bubble").with_value("camera.resolution", [6, 4]).with_value("render.samples", 1)
    ir.sweep(scene, {"camera.fov_deg": [20.0, 30.0]}, store=tmp_path / "a")
    swept = ir.sweep(
        SOAP, VARY, store=tmp_path / "b", quantity=lambda stack: 1.0 / (stack.layers[0].thickness_nm - 200.0)
    )
    assert len(swept.failed) == 1
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert {path.suffix for path in files} == {".exr", ".npy", ".json"}
    for path in files:
        if path.suffix == ".json":
            json.loads(path.read_text())
        elif path.suffix == ".npy":
            np.load(path, allow_pickle=False)
    kept = ir.sweep(scene, {"camera.fov_deg": [20.0, 30.0]}, store=tmp_path / "a").values[1]
    drawn = ir.render(scene.with_value("camera.fov_deg", 30.0))
    np.testing.assert_array_equal(kept.xyz, drawn.xyz)
    for name, plane in drawn.channels.items():
        np.testing.assert_array_equal(kept.channels[name], plane)
    assert kept.metadata["scene"] == drawn.metadata["scene"]


def test_another_sweep_on_the_same_folder_is_refused_with_the_difference(tmp_path: Path) -> None:
    folder = tmp_path / "store"
    ir.sweep(SOAP, VARY, store=folder)
    before = contents(folder)
    for base, vary, quantity, words in (
        ("air / soap 321 / air", VARY, None, "base.stack.layers.0.thickness_nm is 320.0, not 321.0"),
        ("air / water 320 / 1.5", VARY, None, "base.stack"),
        (SOAP, {NM: [100.0, 200.0, 300.0, 401.0]}, None, "thickness_nm.3 is 400.0, not 401.0"),
        (SOAP, {NM: [100.0]}, None, "400.0], not [100.0]"),
        (SOAP, [{NM: 100.0}], None, "its points is not given"),
        (SOAP, VARY, "reflectance", 'quantity is "color", not "reflectance"'),
    ):
        with pytest.raises(ValueError, match="holds another sweep") as caught:
            ir.sweep(base, vary, quantity=quantity, store=folder)
        assert words in str(caught.value)
    assert contents(folder) == before
    ir.sweep(SOAP, {NM: [100, 200, 300, 400]}, store=folder)  # whole numbers of the same value
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "letter.txt").write_text("not ours")
    with pytest.raises(ValueError, match="holds no sweep"):
        ir.sweep(SOAP, VARY, store=tmp_path / "other")


def test_another_function_is_another_sweep(tmp_path: Path) -> None:
    ir.sweep(SOAP, VARY, store=tmp_path / "s", quantity=lambda stack: stack.layers[0].thickness_nm)
    with pytest.raises(ValueError, match="quantity"):
        ir.sweep(SOAP, VARY, store=tmp_path / "s", quantity=lambda stack: 2.0 * stack.layers[0].thickness_nm)


def test_what_the_index_does_not_vouch_for_is_made_again(tmp_path: Path) -> None:
    folder = tmp_path / "s"
    ir.sweep(SOAP, VARY, store=folder)
    before = contents(folder)
    index = folder / "index" / "0001.json"
    whole = index.read_text()

    def made_again() -> int:
        told: list[int] = []
        ir.sweep(SOAP, VARY, store=folder, progress=lambda done, total: told.append(done))
        assert contents(folder) == before
        return 4 - told[0]

    assert made_again() == 0
    (folder / "points" / "000002.npy").write_bytes(before["000002.npy"][:-1] + b"!")
    with pytest.warns(UserWarning, match="not what the index says"):
        assert made_again() == 1
    (folder / "points" / "000001.npy").unlink()
    with pytest.warns(UserWarning, match="points 1"):
        assert made_again() == 1
    for later in sorted((folder / "index").iterdir())[1:]:
        later.unlink()
    # A kill, or a full disk, in the middle of a line; then a line that somebody changed.
    index.write_text(whole[:-60])
    assert made_again() == 1
    (folder / "index" / "0002.json").unlink()
    lines = whole.split("\n")
    lines[3] = lines[3].replace('"point": 1', '"point": 3')
    index.write_text("\n".join(lines))
    with pytest.warns(UserWarning, match="line 4 is damaged"):
        assert made_again() == 3


def test_points_that_failed_are_tried_again(tmp_path: Path) -> None:
    broken = tmp_path / "broken"
    broken.touch()

    def reads(stack: ir.Stack) -> float:
        if broken.exists() and stack.layers[0].thickness_nm == 200.0:
            raise OSError("not there yet")
        return float(stack.layers[0].thickness_nm)

    first = ir.sweep(SOAP, VARY, store=tmp_path / "s", quantity=reads)
    assert first.failed == [({NM: 200.0}, "OSError: not there yet")]
    assert json.loads((tmp_path / "s" / "points" / "000001.json").read_text())["error"] == "OSError: not there yet"
    broken.unlink()
    second = ir.sweep(SOAP, VARY, store=tmp_path / "s", quantity=reads)
    assert not second.failed and second.values.tolist() == [100.0, 200.0, 300.0, 400.0]
    assert not (tmp_path / "s" / "points" / "000001.json").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="limits of file sizes")
def test_a_full_disk_ends_the_sweep_and_leaves_a_store_that_goes_on(tmp_path: Path) -> None:
    code = (
        "import resource, sys, numpy as np, iridesce as ir\n"
        "def spectrum(stack): return np.full(int(stack.layers[0].thickness_nm), 1.0)\n"
        "if sys.argv[1:]: resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))\n"
        f"try: print(len(ir.sweep({SOAP!r}, {VARY!r}, store='s', quantity=spectrum).failed))\n"
        "except OSError as error: print(type(error).__name__, error)\n"
    )

    def run(*words: str) -> str:
        (tmp_path / "code.py").write_text(code)
        done = subprocess.run(
            [sys.executable, "code.py", *words], cwd=tmp_path, capture_output=True, text=True, timeout=120
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "000002.npy" in run("small")
    assert sorted(path.name for path in (tmp_path / "s" / "points").iterdir()) == ["000000.npy", "000001.npy"]
    assert run().strip() == "0"
    assert len(list((tmp_path / "s" / "points").iterdir())) == 4


def test_files_that_a_scene_names_are_found_and_laid_out_by_the_same_names(tmp_path: Path) -> None:
    scene = tmp_path / "project" / "scenes"
    scene.mkdir(parents=True)
    for name in ("project/scenes/a.exr", "project/maps/b.npy", "project/scenes/mesh.gltf", "project/scenes/mesh.bin"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(b'{"buffers": [{"uri": "mesh.bin"}]}' if name.endswith("gltf") else name.encode())
    tree = {"map": "a.exr", "deep": [{"file": "../maps/b.npy"}, "mesh.gltf"], "name": "bubble", "missing": "c.exr"}
    found = needed_files([tree], scene)
    assert sorted(found) == ["../maps/b.npy", "a.exr", "mesh.bin", "mesh.gltf"]
    folder = lay_out(tmp_path / "elsewhere", {name: path.read_bytes() for name, path in found.items()})
    assert (tmp_path / "elsewhere") in folder.parents
    for name, path in found.items():
        assert (folder / name).read_bytes() == path.read_bytes()
    assert all((tmp_path / "elsewhere") in path.resolve().parents for path in (folder / "../maps").iterdir())
