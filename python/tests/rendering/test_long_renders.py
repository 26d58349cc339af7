"""Parts of pictures, pictures that tell when they are done, journals, shards: the bytes of the whole, whatever happens."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

import command_line
import iridesce as ir
from iridesce import _core

SMALL = {"samples": 3, "size": (50, 37)}


@pytest.fixture(scope="module")
def whole() -> ir.Image:
    return ir.render("soap-bubble", **SMALL)


def same(a: ir.Image, b: ir.Image) -> bool:
    """All planes, bit for bit."""
    planes = {"xyz": a.xyz, **a.channels}
    others = {"xyz": b.xyz, **b.channels}
    return planes.keys() == others.keys() and all(planes[key].tobytes() == others[key].tobytes() for key in planes)


# --- crops and planes


@pytest.mark.parametrize("crop", [(0, 0, 50, 37), (13, 5, 20, 30), (49, 36, 1, 1), (3, 17, 17, 16)])
def test_a_crop_has_the_bytes_of_the_whole(whole, crop):
    x, y, width, height = crop
    part = ir.render("soap-bubble", **SMALL, crop=crop)
    assert part.xyz.shape == (height, width, 3)
    for name, plane in {"xyz": whole.xyz, **whole.channels}.items():
        own = part.xyz if name == "xyz" else part.channels[name]
        assert own.tobytes() == plane[y : y + height, x : x + width].tobytes(), name
    assert part.metadata["crop"] == crop
    assert part.metadata["scene"]["camera"]["resolution"] == [50, 37]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"crop": (0, 0, 51, 1)}, "within the picture of 50 x 37"),
        ({"crop": (0, 0, 0, 1)}, "at least one pixel"),
        ({"crop": (0, 0, 1)}, "crop must be"),
        ({"crop": (-1, 0, 1, 1)}, "crop must be"),
        ({"until": 0.0}, "until"),
        ({"until": float("nan")}, "until"),
        ({"time_s": -1.0}, "time_s"),
        ({"shard": (3, 2)}, "got 3 of 2"),
        ({"shard": (0, 2)}, "got 0 of 2"),
        ({"shard": (1, 2), "until": 0.1}, "fixed number of samples"),
    ],
)
def test_what_is_no_part_is_said(arguments, said):
    with pytest.raises(ValueError, match=said):
        ir.render("soap-bubble", **SMALL, **arguments)


def test_planes_of_the_first_surface_and_of_the_samples(whole):
    channels = whole.channels
    assert channels["object"].dtype == channels["samples"].dtype == np.int32
    hit = np.isfinite(channels["depth"])
    assert np.array_equal(channels["object"], np.where(hit, 0, -1))
    assert (channels["samples"] == 3).all()
    assert np.isfinite(channels["variance"]).all()
    assert np.isnan(ir.render("soap-bubble", samples=1, size=(4, 4)).channels["variance"]).all()


def test_the_path_difference_is_2_n_t_cos_theta():
    flat = {
        "version": 1,
        "camera": {"position": [0, 0, 9], "fov_deg": 60.0, "resolution": [9, 9]},
        "object": [
            {
                "name": "film",
                "shape": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}},
                "surface": {"film": {"medium": "soap", "thickness_nm": 400.0}},
            }
        ],
        "light": [{"environment": {"illuminant": "D65"}}],
    }
    image = ir.render(flat, samples=1)
    n = ir.Medium("soap").index(560.0).real
    cosine = 9.0 / image.channels["depth"].astype(float)
    expected = 2.0 * 400.0 * np.sqrt(n**2 - (1.0 - cosine**2))
    np.testing.assert_allclose(image.channels["path_difference_nm"], expected, rtol=1e-6)


def test_variance_is_that_of_the_mean_over_seeds():
    """Against the spread over 24 seeds, by medians over the film. The law that carries batches on falls short of the true fall
    where a pixel gets smoother the closer one looks: too large by up to three times then, never too small."""
    arguments = {"samples": 32, "size": (24, 24)}
    images = [ir.render("soap-bubble", seed=seed, **arguments) for seed in range(24)]
    found = np.var([image.xyz[..., 1] for image in images], axis=0, ddof=1)
    told = np.median([image.channels["variance"] for image in images], axis=0)
    film = np.isfinite(images[0].channels["depth"])
    assert 0.7 < np.median(told[film]) / np.median(found[film]) < 3.0
    # An estimate that knows nothing of how evenly samples are spread would be nine times too large.
    single = [ir.render("soap-bubble", samples=1, size=(24, 24), seed=seed).xyz[..., 1] for seed in range(24)]
    assert np.median(np.var(single, axis=0, ddof=1)[film]) / 32 > 6.0 * np.median(found[film])


# --- passes


def test_passes_go_on_until_the_error_is_reached():
    def error(image: ir.Image) -> float:
        sigma, y = np.sqrt(image.channels["variance"].astype(float)), image.xyz[..., 1].astype(float)
        relative = sigma / np.maximum(y, 0.01 * y.mean())
        return float(np.median(relative[sigma > 0.0]))

    loose = ir.render("soap-bubble", size=(24, 24), until=0.05)
    fine = ir.render("soap-bubble", size=(24, 24), until=0.005)
    assert error(loose) < 0.05
    assert error(fine) < 0.005
    assert fine.metadata["samples"] > loose.metadata["samples"] >= 16, "four passes at least"
    assert (fine.channels["samples"] == fine.metadata["samples"]).all()
    # (The scene's own 64 samples are no limit; the call's are.)
    assert ir.render("soap-bubble", size=(8, 8), until=1e-9, samples=70).metadata["samples"] == 70
    # Without a light there is no sigma, and nothing to wait for.
    repeated = ir.render("soap-bubble", size=(24, 24), until=0.05)
    assert same(loose, repeated)


def test_passes_go_on_for_a_time():
    started = time.perf_counter()
    image = ir.render("soap-bubble", size=(16, 16), time_s=0.5)
    assert time.perf_counter() - started < 1.5
    assert image.metadata["samples"] > 4


# --- journals


def journal_and_whole(folder: Path) -> tuple[Path, ir.Image]:
    path = folder / "x.journal"
    return path, ir.render("soap-bubble", **SMALL, resume=path)


def test_a_torn_journal_gives_the_bytes_of_an_unbroken_render(whole, tmp_path):
    path, image = journal_and_whole(tmp_path)
    assert same(image, whole)
    content = path.read_bytes()
    draw = random.Random(4)
    cuts = [0, 1, 7, 8, 40, len(content) - 1, len(content), *(draw.randrange(len(content)) for _ in range(12))]
    for cut in cuts:
        path.write_bytes(content[:cut])
        assert same(ir.render("soap-bubble", **SMALL, resume=path), whole), cut
        assert path.read_bytes() == content or cut < len(content)
    for at in (draw.randrange(len(content) // 2, len(content)) for _ in range(6)):
        path.write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
        assert same(ir.render("soap-bubble", **SMALL, resume=path), whole), at
    path.write_bytes(content[:60] + bytes([content[60] ^ 1]) + content[61:])
    with pytest.raises(ValueError, match="beginning is damaged"):
        ir.render("soap-bubble", **SMALL, resume=path)


def test_what_a_journal_holds_is_not_drawn_again(whole, tmp_path):
    path, _ = journal_and_whole(tmp_path)
    done = []
    image = ir.render("soap-bubble", **SMALL, resume=path, progress=lambda now, total: done.append(now))
    assert same(image, whole)
    # Damage one tile's sums where the checksum does not see it: a journal written by hand.
    assert path.stat().st_size > 50 * 37 * 28


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"seed": 2}, "seed was 1, now it is 2"),
        ({"size": (50, 36)}, "size"),
        ({"samples": 4}, "samples was 3, now it is 4"),
        ({"crop": (0, 0, 5, 5)}, "crop was null"),
        ({"until": 0.5}, "samples"),
    ],
)
def test_a_journal_of_another_render_is_refused(tmp_path, change, said):
    path, _ = journal_and_whole(tmp_path)
    before = path.read_bytes()
    with pytest.raises(ValueError, match=said):
        ir.render("soap-bubble", **{**SMALL, **change}, resume=path)
    assert path.read_bytes() == before


def test_a_journal_of_another_scene_version_or_level_is_refused(tmp_path, monkeypatch):
    path, _ = journal_and_whole(tmp_path)
    scene = ir.Scene.load("soap-bubble").with_value("camera.fov_deg", 36.0)
    with pytest.raises(ValueError, match=r"scene.camera.fov_deg was 35.0, now it is 36.0"):
        ir.render(scene, **SMALL, resume=path)
    monkeypatch.setattr(_core, "__version__", "9.9")
    with pytest.raises(ValueError, match="version was"):
        ir.render("soap-bubble", **SMALL, resume=path)
    monkeypatch.undo()
    monkeypatch.setattr(_core, "SIMD_LEVEL", "another")
    with pytest.raises(ValueError, match="SIMD level was"):
        ir.render("soap-bubble", **SMALL, resume=path)
    path.write_text("a picture perhaps")
    with pytest.raises(ValueError, match="no journal"):
        ir.render("soap-bubble", **SMALL, resume=path)


KILLED = """
import sys, iridesce as ir
ir.render("soap-bubble", samples=64, size=(160, 120), threads=2, resume=sys.argv[1])
print("whole")
"""


def test_a_killed_render_goes_on_where_it_was(tmp_path):
    """kill -9 at random moments, again and again; the end is that of an unbroken render."""
    path = tmp_path / "x.journal"
    draw = random.Random(11)
    kept = []
    for _ in range(4):
        process = subprocess.Popen([sys.executable, "-c", KILLED, str(path)], stdout=subprocess.PIPE, text=True)
        waited = time.perf_counter()
        size = path.stat().st_size if path.exists() else 0
        while process.poll() is None and time.perf_counter() - waited < 20.0:
            if path.exists() and path.stat().st_size > size + draw.randrange(1, 60_000):
                break
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        kept.append(path.stat().st_size)
    assert kept == sorted(kept), "nothing that was finished is lost"
    resumed = ir.render("soap-bubble", samples=64, size=(160, 120), resume=path)
    assert same(resumed, ir.render("soap-bubble", samples=64, size=(160, 120)))


# --- shards


def test_shards_merge_to_the_bytes_of_the_whole(whole, tmp_path):
    shards = [ir.render("soap-bubble", **SMALL, shard=(i, 3)) for i in (1, 2, 3)]
    for shard in shards:
        outside = shard.channels["samples"] == 0
        assert outside.any() and not outside.all()
        assert (shard.xyz[outside] == 0.0).all()
    assert same(ir.merge(shards), whole)
    files = []
    for number, shard in enumerate(shards):
        files.append(tmp_path / f"{number}.exr")
        shard.save(files[-1])
    ir.merge(files).save(tmp_path / "merged.exr")
    whole.save(tmp_path / "whole.exr")
    assert (tmp_path / "merged.exr").read_bytes() == (tmp_path / "whole.exr").read_bytes()


def test_an_incomplete_set_says_what_is_missing_and_can_be_merged_again(whole):
    shards = [ir.render("soap-bubble", **SMALL, shard=(i, 3)) for i in (1, 2, 3)]
    with pytest.warns(UserWarning, match=r"shard 3/3 of seed 1 missing \(4 of 12 tiles\)"):
        some = ir.merge(shards[:2])
    assert (some.channels["samples"] == 0).any()
    with pytest.raises(ValueError, match="both hold tile 0 of seed 1"):
        ir.merge([some, shards[0]])
    assert same(ir.merge([some, shards[2]]), whole)


def test_other_seeds_are_weighted_by_samples(whole):
    other = ir.render("soap-bubble", samples=6, seed=2, size=SMALL["size"])
    joined = ir.merge([whole, other])
    np.testing.assert_allclose(joined.xyz, (whole.xyz + 2.0 * other.xyz.astype(float)) / 3.0, rtol=1e-6, atol=1e-7)
    expected = (whole.channels["variance"] + 4.0 * other.channels["variance"].astype(float)) / 9.0
    np.testing.assert_allclose(joined.channels["variance"], expected, rtol=1e-6)
    assert (joined.channels["samples"] == 9).all()
    assert [run["seed"] for run in joined.metadata["merged"]] == [1, 2]
    with pytest.raises(ValueError, match="both hold tile 0 of seed 2"):
        ir.merge([joined, other])


def test_what_cannot_be_merged_is_said(whole, tmp_path):
    for change, said in (
        ({"size": (50, 36)}, "size"),
        ({"crop": (0, 0, 50, 36)}, "size"),
        ({"samples": 4, "seed": 1, "shard": (1, 2)}, "both hold tile"),
    ):
        with pytest.raises(ValueError, match=said):
            ir.merge([whole, ir.render("soap-bubble", **{**SMALL, **change})])
    scene = ir.Scene.load("soap-bubble").with_value("camera.fov_deg", 36.0)
    with pytest.raises(ValueError, match=r"scene.camera.fov_deg = 35.0 and 36.0|scene camera.fov_deg = 35.0 and 36.0"):
        ir.merge([whole, ir.render(scene, **SMALL, seed=2)])
    for wrong in ([whole], [], "x.exr", [whole, 3], [whole, ir.Image(np.ones((37, 50, 3)))]):
        with pytest.raises(ValueError, match=r"images|how it was rendered"):
            ir.merge(wrong)
    with pytest.raises(ValueError, match="no such file"):
        ir.merge([whole, tmp_path / "none.exr"])


# --- the command line


def run(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return command_line.run(arguments, folder, timeout=120)


def test_the_verbs_shard_merge_and_crop(whole, tmp_path):
    size = ("--samples", "3", "--size", "50x37")
    for i in (1, 2):
        finished = run("render", "soap-bubble", *size, "--shard", f"{i}/2", "-o", f"{i}.exr", folder=tmp_path)
        assert finished.returncode == 0, finished.stderr
    finished = run("merge", "1.exr", "2.exr", "-o", "merged.exr", folder=tmp_path)
    assert (finished.returncode, finished.stdout) == (0, "merged.exr\n")
    assert same(ir.Image.load(tmp_path / "merged.exr"), whole)
    twice = run("merge", "1.exr", "1.exr", "-o", "twice.exr", folder=tmp_path)
    assert twice.returncode == 3
    assert "both hold tile 0" in twice.stderr
    run("render", "soap-bubble", *size, "--crop", "5,6,7,8", "--half", "-o", "crop.exr", folder=tmp_path)
    crop = ir.Image.load(tmp_path / "crop.exr")
    np.testing.assert_allclose(crop.xyz, whole.xyz[6:14, 5:12], rtol=2**-11)
    for wrong in (("--crop", "1,2,3"), ("--shard", "3/2"), ("--bits", "9"), ("--space", "cmyk")):
        assert run("render", "soap-bubble", *size, *wrong, folder=tmp_path).returncode == 2, wrong


# The command line, whose renders are long after two seconds, not ten.
SOON_LONG = """
from iridesce.cli import main
from iridesce.cli.verbs import render
assert render._JOURNAL_AFTER_S == 10.0
render._JOURNAL_AFTER_S = 2.0
main()
"""


@pytest.mark.slow
def test_a_long_render_of_the_command_line_leaves_a_journal_when_killed(tmp_path):
    command = ["render", "soap-bubble", "--samples", "4096", "--size", "400x300", "--threads", "1", "-o", "x.exr"]
    process = subprocess.Popen(
        [sys.executable, "-c", SOON_LONG, *command], cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    journal = tmp_path / "x.exr.journal"
    started = time.perf_counter()
    while not journal.exists() and time.perf_counter() - started < 60.0:
        time.sleep(0.05)
    assert time.perf_counter() - started > 1.8, "nothing is written before a render is long"
    time.sleep(0.5)
    process.kill()
    process.wait()
    assert not (tmp_path / "x.exr").exists()
    refused = run(*command, "--seed", "3", "--resume", folder=tmp_path)
    assert refused.returncode == 3
    assert "seed was 1, now it is 3" in refused.stderr
    before = journal.read_bytes()
    process = subprocess.Popen(
        [sys.executable, "-c", SOON_LONG, *command, "--resume"],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    while journal.stat().st_size <= len(before) and time.perf_counter() - started < 90.0:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=20) == 130
    assert journal.read_bytes().startswith(before[: len(before) // 2])


def test_a_render_that_is_asked_to_resume_keeps_a_journal_from_its_first_tile_on(tmp_path):
    never = (
        "from iridesce.cli import main\nfrom iridesce.cli.verbs import render\nrender._JOURNAL_AFTER_S = 1e9\nmain()"
    )
    command = ["render", "soap-bubble", "--samples", "4096", "--size", "400x300", "--resume", "-o", "x.exr"]
    process = subprocess.Popen(
        [sys.executable, "-c", never, *command], cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    journal = tmp_path / "x.exr.journal"
    started = time.perf_counter()
    while not journal.exists() and process.poll() is None and time.perf_counter() - started < 30.0:
        time.sleep(0.05)
    process.kill()
    process.wait()
    assert journal.exists()


def test_the_journal_goes_when_the_file_is_whole(tmp_path):
    size = ("--samples", "3", "--size", "50x37", "-o", "x.exr")
    ir.render("soap-bubble", **SMALL, resume=tmp_path / "x.exr.journal")
    finished = run("render", "soap-bubble", *size, "--resume", folder=tmp_path)
    assert finished.returncode == 0, finished.stderr
    assert [entry.name for entry in tmp_path.iterdir()] == ["x.exr"]


def test_nothing_warns():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ir.render("soap-bubble", samples=2, size=(8, 8))
