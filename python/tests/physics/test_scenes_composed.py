"""What built-in scenes are to show lies within what they stand on, and within the picture."""

from __future__ import annotations

import numpy as np

import iridesce as ir


def test_the_plate_holds_the_whole_reflection_of_the_dome() -> None:
    scene = ir.Scene.load("soap-dome").to_dict()
    cap, plate = (item["shape"] for item in scene["object"])
    camera, radius = np.array(scene["camera"]["position"]), cap["cap"]["radius_of_curvature"]
    middle = np.array(cap["cap"]["center"]) - radius * np.array(cap["cap"]["axis"])
    polar, turn = np.meshgrid(np.linspace(0.0, np.pi / 2.0, 91), np.linspace(0.0, 2.0 * np.pi, 181))
    dome = middle + radius * np.stack(
        [np.sin(polar) * np.cos(turn), np.cos(polar), np.sin(polar) * np.sin(turn)], axis=-1
    )
    # Where the way from the camera to the mirrored dome meets the plate.
    image = dome * [1.0, -1.0, 1.0]
    share = camera[1] / (camera[1] - image[..., 1:2])
    met = camera + share * (image - camera)
    assert np.hypot(met[..., 0], met[..., 2]).max() < plate["disk"]["radius"]
    # The plate itself is in the picture, with its rim.
    rim = plate["disk"]["radius"] * np.array([[np.sin(a), 0.0, np.cos(a)] for a in np.linspace(0.0, 2.0 * np.pi, 73)])
    forward = np.array(scene["camera"]["target"]) - camera
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    way = rim - camera
    depth, half = way @ forward, np.tan(np.radians(scene["camera"]["fov_deg"]) / 2.0)
    width, height = scene["camera"]["resolution"]
    assert np.abs(way @ np.cross(right, forward) / depth).max() < half
    assert np.abs(way @ right / depth).max() < half * width / height


def test_something_of_known_size_floats_on_the_slick() -> None:
    scene = ir.Scene.load("oil-slick")
    names = [item["name"] for item in scene.to_dict()["object"]]
    ball = scene.to_dict()["object"][names.index("cherry")]["shape"]["sphere"]
    assert 0.01 < ball["radius"] < 0.02 and -ball["radius"] < ball["center"][1] < ball["radius"]
    shown = ir.render(scene, size=(160, 120), samples=1).channels["object"] == names.index("cherry")
    assert 10 < shown.sum() < 200
