"""What fits refuse: argument, value, what is allowed and place of each message, and its words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import iridesce as ir
from iridesce.arguments.refusals import short
from iridesce.inverse import series_data
from refused import Case, check

NM = np.linspace(450.0, 700.0, 60)
R = ir.Stack(["air", ir.Layer("soap", 320.0), "air"]).reflectance(NM)
OPEN, TWO, GAP = "air / soap ? / air", "air / SiO2 ? / TiO2 ? / Si", "N-BK7 / air ? / N-BK7"
SEEN = np.random.default_rng(1).random((40, 40, 3))
SLOPE = np.linspace(0.0, 2500.0, 40) + np.zeros((40, 1))
_Y, _X = np.mgrid[0:80, 0:80]
WIDE = 0.6 * ((_Y - 40.0) ** 2 + (_X - 40.0) ** 2)
LENS = ir.thickness.lens_gap(1000.0)
learn = ir.CameraCalibration.from_known
POWER = ir.Measurement("reflectance", NM, R)
# Counts where the reference is dark, but for three of them.
FIRST = np.where(np.arange(60) < 20, R, np.nan)
DARK = np.where((np.arange(60) >= 3) & (np.arange(60) < 20), 1.0, 100.0)
INFRARED = ir.color.Illuminant.from_csv("nm,power\n800,1\n900,2\n", "infrared")

CASES: list[Case] = [
    (lambda: ir.fit_thickness(NM, R, OPEN, probability=1.0), None, *("probability", "1.0", "> 0 and < 1", "")),
    (
        lambda: ir.fit_thickness(NM, R),
        "stack must say what the film is: text like 'air / soap ? / air', a Stack, or a list",
        *("stack", "None", "text, a Stack, or a list", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, None, OPEN),
        "wavelength_nm and measured must be given, or measurements=",
        *("measured", "None", "given, or measurements=", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, None, OPEN, measurements=[]),
        "wavelength_nm goes without measurements=, each of which has its own",
        *("wavelength_nm", "both", "left out beside measurements=", ""),
    ),
    (
        lambda: ir.fit_thickness(stack=OPEN, measurements=[1]),
        None,
        *("measurements", "[1]", "a list of ir.Measurement", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, gain=0.0),
        None,
        *("gain", "0", 'None, "linear", "quadratic" or a number > 0', ""),
    ),
    (
        lambda: ir.fit_thickness(NM[:8], R[:8], OPEN),
        "8 usable points are too few for 4 unknowns; at least 12",
        *("measured", "8", "12 usable points or more", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, thickness_range_nm=(1.0, 2e6)),
        "thickness_range_nm must end at 1e6 nm at most, got [[1.0, 2000000.0]]",
        *("thickness_range_nm", "[[1.0, 2000000.0]]", "end at 1e6 nm at most", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, thickness_range_nm=(1.0, 2.0, 3.0)),
        None,
        *("thickness_range_nm", "(1.0, 2.0, 3.0)", "(low, high), or one pair for each of 1 unknowns", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, dark=R),
        "dark and reference_stack go with a reference: give reference=, too",
        *("dark", "no reference", "given with a reference", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, reference=R[:9]),
        "wavelength_nm, measured, reference and dark must be of one length, got 60, 60, 9, 60",
        *("measured", "60, 60, 9, 60", "as long as wavelength_nm, reference and dark", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, reference=R, dark=R),
        "the reference is above the dark by 3 standard deviations at 0 of 60 points, "
        "at least 12 are needed: check dark and reference",
        *("reference", "0 of 60 points", "above the dark by 3 standard deviations at 12 points or more", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, reference=R, reference_stack=3),
        None,
        *("reference_stack", "3", "a Stack or text like 'air / Si'", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, noise=[1.0, 2.0]),
        None,
        *("noise", "2", "one number or one a point (60)", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, index="linear"),
        'index must be None, "constant" or "cauchy", got \'linear\'',
        *("index", "'linear'", 'None, "constant" or "cauchy"', ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, index={"water": "constant"}),
        None,
        *("index", "'water'", "by layer: 1 to 1 or the name of one of the layers soap", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, "air / soap 100 / air", layer=[1, 1]),
        "layer must name one or more different layers, got [1, 1]",
        *("layer", "[1, 1]", "name one or more different layers", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, "air / Si"),
        "the stack has no layer whose thickness could be found: Stack(['air', 'Si'])",
        *("stack", "Stack(['air', 'Si'])", "a stack with a layer", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, 3),
        None,
        *("stack", "3", "an iridesce.Stack, a list, or text like 'air / soap ? / air'", ""),
    ),
    (
        lambda: ir.fit_series(NM, [R, R], TWO),
        "a series has one unknown thickness, the stack has 2",
        *("stack", "2", "one with one unknown thickness", ""),
    ),
    (
        lambda: ir.fit_series(NM, [R, R], OPEN, [1.0, 0.0]),
        "time_s must be finite and ascending",
        *("time_s", "others", "finite and ascending", ""),
    ),
    (
        lambda: ir.fit_series(np.r_[NM[:-1], NM[0]], [R, R], OPEN),
        "wavelength_nm must not repeat",
        *("wavelength_nm", "some twice", "different wavelengths", ""),
    ),
    (
        lambda: ir.fit_series(NM[:8], [R[:8]], OPEN),
        "8 usable wavelengths are too few for a series; at least 24",
        *("wavelength_nm", "8", "24 usable wavelengths or more", ""),
    ),
    (
        lambda: ir.fit_series(NM, [R, R], OPEN, thickness_range_nm=(5.0, 1.0)),
        None,
        *("thickness_range_nm", "(5.0, 1.0)", "0 <= low < high <= 100 000", ""),
    ),
    (
        lambda: ir.fit_series(NM, [R, R[:9]], OPEN),
        "spectra must be of one length, a value at each of 60 wavelengths, got 9 in spectrum 1",
        *("spectra", "9 values", "60 values each", "in spectrum 1"),
    ),
    (
        lambda: ir.fit_series(None, "spectrum.txt", OPEN),
        None,
        *("spectra", "'spectrum.txt'", "a list of paths where wavelength_nm is None", ""),
    ),
    (
        lambda: learn(SEEN, TWO, SLOPE),
        "stack must have one unknown thickness, got 2",
        *("stack", "2", "have one unknown thickness", ""),
    ),
    (
        lambda: learn(SEEN, GAP, LENS),
        "pixel_um is needed to lay out a thickness model",
        *("pixel_um", "None", "a number > 0 with a thickness model", ""),
    ),
    (lambda: learn(SEEN, GAP, LENS, pixel_um=-1.0), None, *("pixel_um", "-1.0", "> 0 and < 1000000", "")),
    (lambda: learn(SEEN, GAP, LENS, pixel_um=50.0, center="x"), None, *("center", "'x'", "(x, y) in pixels", "")),
    (
        lambda: learn(SEEN, GAP, SLOPE[:3]),
        "thickness_nm must hold a value for each pixel (40, 40), got (3, 40)",
        *("thickness_nm", "(3, 40)", "hold a value for each pixel (40, 40)", ""),
    ),
    (
        lambda: learn(SEEN, GAP, -1.0 - SLOPE),
        "thickness_nm must be >= 0, and known somewhere that is not masked",
        *("thickness_nm", "values below 0, or none", ">= 0, and known somewhere that is not masked", ""),
    ),
    (
        lambda: learn(np.full((40, 40, 3), 0.5), GAP, SLOPE),
        "a channel of the picture has one value throughout: it shows no film",
        *("image", "one with a constant channel", "a picture whose channels vary", ""),
    ),
    (
        lambda: learn(SEEN, GAP, SLOPE),
        "only 40 thicknesses have 4 pixels or more; at least 60 are needed",
        *("thickness_nm", "40", "60 thicknesses with 4 pixels each, or more", ""),
    ),
    (
        lambda: learn(SEEN, GAP, SLOPE, mask=np.zeros((3, 3), bool)),
        "mask must hold true or false for each pixel (40, 40), got shape (3, 3) of type bool",
        *("mask", "shape (3, 3) of type bool", "hold true or false for each pixel (40, 40)", ""),
    ),
    (
        lambda: learn(SEEN[..., 0], GAP, SLOPE),
        None,
        *(
            "image",
            "ndarray of shape (40, 40) and type float64",
            "linear numbers of the shape (height, width, 3), a picture's file or an Image",
            "",
        ),
    ),
    (
        lambda: learn(SEEN, GAP, SLOPE, dark=[1.0, 2.0]),
        None,
        *(
            "dark",
            "list of shape (2,) and type float64",
            "linear numbers of the shape (height, width, 3), a picture's file or an Image",
            "",
        ),
    ),
    (
        lambda: ir.map_thickness(SEEN, TWO),
        "stack must have one unknown thickness for a photograph (three numbers a pixel), got 2",
        *("stack", "2", "have one unknown thickness for a photograph (three numbers a pixel)", ""),
    ),
    (
        lambda: ir.map_thickness(SEEN, OPEN, thickness_range_nm=(5.0, 1.0)),
        None,
        *("thickness_range_nm", "(5, 1)", "0 <= low < high <= 12000", ""),
    ),
    (
        lambda: ir.map_thickness(SEEN, OPEN, thickness_range_nm=3),
        None,
        *("thickness_range_nm", "3", "(low, high) in nm", ""),
    ),
    (
        lambda: ir.map_thickness(SEEN, OPEN, tie_points=[(90, 1, 100.0)]),
        "a tie point must lie in the picture of 40 x 40 pixels, with nm >= 0, got (90, 1, 100.0)",
        *("tie_points", "(90, 1, 100.0)", "in the picture of 40 x 40 pixels, with nm >= 0", ""),
    ),
    (lambda: ir.map_thickness(SEEN, OPEN, tie_points=[1]), None, *("tie_points", "1", "a list of (x, y, nm)", "")),
    (lambda: ir.map_thickness(SEEN, OPEN, clip=-1.0), None, *("clip", "-1.0", "one level or three, > 0", "")),
    (
        lambda: ir.map_thickness_video(SEEN, OPEN),
        "frames must be several images, one after the other; of one picture: map_thickness",
        *("frames", "one picture", "several images, one after the other", ""),
    ),
    (
        lambda: ir.map_thickness_video("film.mp4", OPEN),
        "frames must be images, or a folder of pictures, got 'film.mp4'; "
        "take a video apart first (ffmpeg -i film.mp4 frames/%05d.png)",
        *("frames", "'film.mp4'", "images, or a folder of pictures", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=[], substrate="Si"),
        None,
        *("media", "none", "a list of one or more media", ""),
    ),
    (lambda: ir.recipes([50, 0, 0], media="SiO2", substrate="Si"), None, *("media", "'SiO2'", "a list of media", "")),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", layers=[4]),
        None,
        *("layers", "4", "a whole number from 1 to 3", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", thickness_range_nm=(5.0, 1.0)),
        None,
        *("thickness_range_nm", "(5.0, 1.0)", "0 <= low < high <= 10 000", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", coupons=[(10.0, 20.0)]),
        "coupons of two voltages at least are needed, got [10.0] V",
        *("coupons", "[10.0] V", "of two voltages at least", ""),
    ),
    (
        lambda: ir.Measurement("counts", NM, R, reference_stack="air / Si"),
        'quantity must be "reflectance", "transmittance", "psi" or "delta", got \'counts\'',
        *("quantity", "'counts'", '"reflectance", "transmittance", "psi" or "delta"', ""),
    ),
    (
        lambda: ir.Measurement("reflectance", NM, R[:9]),
        "wavelength_nm and values of reflectance, 0 degrees must be of one length, got 60, 9",
        *("values", "9", "as long as wavelength_nm (60)", "of reflectance, 0 degrees"),
    ),
    (
        lambda: ir.Measurement("reflectance", NM[:3], R[:3]),
        "reflectance, 0 degrees has 3 usable points, at least 4 are needed",
        *("values", "3", "4 usable points or more", "of reflectance, 0 degrees"),
    ),
    (
        lambda: ir.Measurement("psi", NM, R, angle_deg=60.0, gain=1.0),
        "psi has no gain, baseline or polarization",
        *("quantity", "'psi'", "reflectance or transmittance where gain, baseline or polarization is given", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, gain=-1.0),
        None,
        *("gain", "-1", 'None, "linear", "quadratic" or a number > 0', ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, layer=1.5),
        None,
        *("layer", "1.5", "1 to 1 or the name of one of the layers soap", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, OPEN, index=3),
        None,
        *("index", "3", 'None, "constant", "cauchy" or a dict of these by layer', ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, TWO, layer=1),
        "layer 2 has no thickness and is not among the unknown ones, layer=1",
        *("layer", "1", "all that have no thickness, 2 among them", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, "air / SiO2 ? / TiO2 80 / Si", index={2: "constant"}),
        "index names a layer whose thickness is not unknown, got {2: 'constant'}",
        *("index", "{2: 'constant'}", "of layers whose thickness is unknown", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, ir.Stack(["air", ir.Layer("SiO2", 1.0), ir.Layer("TiO2", 1.0), "Si"])),
        "the stack has 2 coherent layers: say which thickness is unknown, by layer=1 to 2 "
        "(or several: [1, 2]), or in text by '?'",
        *("layer", "None", "1 to 2, or several of them", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R, "air / SiO2 500 incoherent / Si", layer=1),
        "layer 1 is incoherent: it has no fringes that could tell its thickness",
        *("layer", "1", "a coherent layer", ""),
    ),
    (
        lambda: ir.Measurement("reflectance", NM, R, dark=R),
        "dark and reference_stack go with a reference: give reference=, too",
        *("dark", "no reference", "given with a reference", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", coupons=[(0.0, 20.0), (9.0, 30.0)]),
        None,
        *("coupons", "[(0.0, 20.0), (9.0, 30.0)]", "finite, their volts > 0", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", coupons=[(5.0, 30.0), (9.0, 20.0)]),
        "coupons must grow thicker with the voltage; a line through them has -2.5 nm a volt",
        *("coupons", "-2.5 nm a volt", "ones that grow thicker with the voltage", ""),
    ),
    (
        lambda: learn(SEEN, GAP, np.zeros((40, 40)) + np.linspace(0, 90, 1600).reshape(40, 40)),
        "thickness_nm spans 90 nm; a response can be learnt from 250 nm on, better from 2000",
        *("thickness_nm", "90 nm", "250 nm wide or more", ""),
    ),
    (
        lambda: ir.fit_thickness(stack=OPEN, measurements=[ir.Measurement("reflectance", NM, R * 1e200)]),
        "values of reflectance, 0 degrees reach 7.87e+198, whose squares no number holds; give them in another unit",
        *("values", "7.87e+198", "of a size of 1e-60 to 1e+60", "of reflectance, 0 degrees"),
    ),
    (
        lambda: ir.map_thickness(
            SEEN,
            OPEN,
            calibration=learn(
                ir.Stack(["N-BK7", ir.Layer("air", WIDE), "N-BK7"]).color(space="linear-srgb"), GAP, WIDE
            ),
            illuminant="D65",
        ),
        "calibration stands for camera and illuminant: give it or them",
        *("illuminant", "both", "left out beside a calibration", ""),
    ),
    (
        lambda: ir.map_thickness(SEEN, OPEN, noise=-1.0),
        None,
        *("noise", "-1.0", "one number or three, finite and > 0", ""),
    ),
    (
        lambda: ir.map_thickness(SEEN, OPEN, clip=[1.0, 2.0]),
        None,
        *("clip", "[1.0, 2.0]", "one level or three, > 0", ""),
    ),
    (lambda: ir.map_thickness(SEEN, OPEN, clip="x"), None, *("clip", "'x'", "one level or three, > 0", "")),
    (
        lambda: ir.map_thickness(SEEN[:1, :1], OPEN),
        "image must have at least 8 x 8 pixels, got 1 x 1",
        *("image", "1 x 1", "have at least 8 x 8 pixels", ""),
    ),
    (
        lambda: ir.map_thickness([1, 2], OPEN),
        None,
        *(
            "image",
            "list of shape (2,) and type int64",
            "linear numbers of the shape (height, width, 3), a picture's file or an Image",
            "",
        ),
    ),
    (
        lambda: ir.map_thickness(3, OPEN),
        None,
        *(
            "image",
            "int of shape () and type int64",
            "linear numbers of the shape (height, width, 3), a picture's file or an Image",
            "",
        ),
    ),
    (
        lambda: ir.map_thickness(SEEN, OPEN, flat=np.zeros((40, 40, 3))),
        "flat must be brighter than dark: it is 0 or less everywhere",
        *("flat", "nowhere", "brighter than dark at some pixel", ""),
    ),
    (
        lambda: ir.map_thickness(SEEN, OPEN, flat=np.ones((3, 3, 3))),
        "flat must have at least 8 x 8 pixels, got 3 x 3",
        *("flat", "3 x 3", "have at least 8 x 8 pixels", ""),
    ),
    (
        lambda: ir.map_thickness(np.full((40, 40, 3), np.nan), OPEN),
        "image holds no number at all that is finite and below 3.4e38",
        *("image", "none", "a picture with numbers in it", ""),
    ),
    (lambda: ir.map_thickness(SEEN, OPEN, angle_deg=95.0), None, *("angle_deg", "95", ">= 0 and < 90", "")),
    (
        lambda: ir.map_thickness(SEEN, OPEN, angle_deg=[1.0, 2.0]),
        None,
        *("angle_deg", "shape (2,)", "one number or one a pixel (40, 40)", ""),
    ),
    (
        lambda: ir.map_thickness(SEEN, OPEN, camera="x"),
        'camera must be None, "srgb", "xyz", one of nikon-d5100, sigma-sd-merrill, or a file of '
        "sensitivities (CSV nm,r,g,b or JSON), got 'x'",
        *(
            "camera",
            "'x'",
            'None, "srgb", "xyz", one of nikon-d5100, sigma-sd-merrill, or a file of sensitivities (CSV nm,r,g,b or JSON)',
            "",
        ),
    ),
    (
        lambda: learn(SEEN, GAP, LENS, pixel_um=50.0, center=(np.nan, 1.0)),
        None,
        *("center", "(nan, 1.0)", "finite", ""),
    ),
    (
        lambda: learn(np.random.default_rng(1).random((80, 80, 3)), GAP, WIDE),
        "the picture does not show this film: 100 % of its contrast is left over (center, pixel_um, stack, "
        "or a curve that is not linear)",
        *("image", "one with 100 % of its contrast left over", "a picture of this film", ""),
    ),
    (lambda: ir.map_thickness_video(3, OPEN), None, *("frames", "3", "images, one after the other", "")),
    (
        lambda: ir.fit_thickness(stack=OPEN, index="cauchy", measurements=[ir.Measurement("reflectance", NM, R)]),
        None,
        *("index", '"cauchy"', 'None or "constant" with measurements=', ""),
    ),
    (
        lambda: ir.fit_thickness(
            stack="air / SiO2 ? / N-BK7 1e6 incoherent / air",
            measurements=[ir.Measurement("psi", NM, 50.0 * R, angle_deg=60.0)],
        ),
        "psi and delta need a stack without incoherent layers",
        *(
            "stack",
            "Stack(['air', Layer('SiO2', thickness_nm=0.0), Layer('N-B...",
            "one without incoherent layers for psi and delta",
            "",
        ),
    ),
    (
        lambda: ir.fit_thickness(NM, R, "air / SiO2 ? / TiO2 ? / SiO2 ? / TiO2 ? / Si"),
        "4 unknown thicknesses within [(1.0, 1500.0), (1.0, 1500.0), (1.0, 1500.0), (1.0, 1500.0)] nm make "
        "92160000 trials, at most 60000 are made: give narrower thickness_range_nm, one (low, high) for each",
        *("thickness_range_nm", "92160000", "narrow enough for 60000 trials", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, np.full(60, np.nan), OPEN),
        "wavelength_nm and measured hold no usable point",
        *("measured", "nothing usable", "finite at some wavelength > 0", ""),
    ),
    (
        lambda: ir.fit_thickness(NM[:9], R[:9], OPEN, reference=R[:9]),
        "9 points are too few for counts; at least 12",
        *("measured", "9", "12 points or more", ""),
    ),
    (
        lambda: ir.fit_thickness(NM, R[:, None], OPEN),
        None,
        *("measured", "shape (60, 1)", "real numbers along one axis", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", coupons=3),
        None,
        *("coupons", "3", "a list of (volt, nm) or of (volt, (L, a, b)), all of one kind", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", coupons=[1, 2]),
        None,
        *("coupons", "[1, 2]", "a list of (volt, nm) or of (volt, (L, a, b)), all of one kind", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", coupons=[(1.0, -20.0), (9.0, 30.0)]),
        "coupons must have thicknesses >= 0 nm, got [-20.0, 30.0]",
        *("coupons", "[-20.0, 30.0]", "have thicknesses >= 0 nm", ""),
    ),
    (
        lambda: ir.recipes(
            [50, 0, 0], media=["SiO2", "TiO2"], substrate="Si", coupons=[(1.0, (50, 0, 0)), (9.0, (60, 0, 0))]
        ),
        "coupons by colour need one medium, the oxide; media has 2",
        *("media", "2", "one medium, the oxide, beside coupons by colour", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", layers=[]),
        None,
        *("layers", "none", "a list of 1, 2 and 3", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", layers="x"),
        None,
        *("layers", "'x'", "a whole number from 1 to 3", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", sigma=0.1, sigma_nm=1.0),
        None,
        *("sigma_nm", "both", "left out beside sigma", ""),
    ),
    (
        lambda: ir.recipes([50, 0], media=["SiO2"], substrate="Si"),
        None,
        *("target", "[50, 0]", "three finite numbers", ""),
    ),
    (
        lambda: ir.recipes([500, 0, 0], media=["SiO2"], substrate="Si"),
        "target has a lightness L of 500; films have 0 to 100 (is space='lab' right?)",
        *("target", "L = 500", "of a lightness from 0 to 100", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", thickness_range_nm=3),
        None,
        *("thickness_range_nm", "3", "(low, high) in nm", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["air"], substrate="Si"),
        "no layer of these media has two faces that reflect: media beside themselves, the substrate or the outside",
        *("media", "none", "media of which a layer has two faces that reflect", ""),
    ),
    (
        lambda: ir.fit_series(NM, R, OPEN),
        "spectra must have the shape (n, 60) for 60 wavelengths, got (60,)",
        *("spectra", "(60,)", "have the shape (n, 60) for 60 wavelengths", ""),
    ),
    (
        lambda: ir.fit_series(NM - 450.0, [R], OPEN),
        "wavelength_nm must be > 0 and finite",
        *("wavelength_nm", "others", "> 0 and finite", ""),
    ),
    (
        lambda: ir.fit_series(NM, [R, R], OPEN, [1.0, 2.0, 3.0]),
        "time_s must have one time a spectrum (2), got shape (3,)",
        *("time_s", "shape (3,)", "have one time a spectrum (2)", ""),
    ),
    (
        lambda: ir.fit_series(None, [1, 2], OPEN),
        "spectra must be a list of paths where wavelength_nm is None",
        *("spectra", "[1, 2]", "a list of paths where wavelength_nm is None", ""),
    ),
    (
        lambda: ir.fit_series(NM, [R], OPEN, thickness_range_nm=3),
        None,
        *("thickness_range_nm", "3", "(low, high) in nm", ""),
    ),
    (
        lambda: ir.Measurement("psi", NM, R, angle_deg=60.0, reference=R),
        "psi is no count, and has no reference",
        *("reference", "given", "left out for psi and delta", ""),
    ),
    (
        lambda: ir.Measurement("reflectance", NM, R, reference=R[:3]),
        "reference and values of reflectance, 0 degrees must be of one length, got 3, 60",
        *("reference", "3", "as long as values (60)", "of reflectance, 0 degrees"),
    ),
    (
        lambda: ir.Measurement("reflectance", NM, R, noise=[1.0, 2.0]),
        None,
        *("noise", "2", "one number or one a point (60)", ""),
    ),
    (
        lambda: ir.Measurement("reflectance", NM, R, noise=np.zeros(60)),
        None,
        *("noise", "0.0 to 0.0", "> 0 and finite", ""),
    ),
    (
        lambda: ir.Measurement("reflectance", NM[:, None], R),
        "wavelength_nm must have one axis, got shape (60, 1)",
        *("wavelength_nm", "shape (60, 1)", "have one axis", ""),
    ),
    (
        lambda: ir.fit_thickness(
            stack=OPEN, measurements=[ir.Measurement("reflectance", NM, FIRST, reference=DARK, dark=np.ones(60))]
        ),
        "reflectance, 0 degrees has 3 usable points, at least 4 are needed; 17 of 60 points dropped: no light in the "
        "reference; 40 of 43 points dropped: not finite, beyond 1e+09 times the others, or a wavelength or noise that "
        "is not > 0",
        *("values", "3", "4 usable points or more", "of reflectance, 0 degrees"),
    ),
    (
        lambda: ir.fit_thickness(stack=TWO, measurements=[POWER], thickness_range_nm=(1.0, 200_000.0)),
        "the thicknesses asked for make 7777859 trials, at most 200000 are made: give a narrower thickness_range_nm",
        *("thickness_range_nm", "7777859", "narrow enough for 200000 trials", ""),
    ),
    (
        lambda: ir.map_thickness(SEEN, OPEN, mask=np.ones((40, 40), bool)),
        "mask (or NaN) leaves no pixel of the picture",
        *("mask", "all masked", "one that leaves pixels of the picture", ""),
    ),
    (
        lambda: learn(SEEN, GAP, SLOPE, mask=np.ones((40, 40), bool)),
        "mask, NaN or full channels leave no pixel of the picture",
        *("mask", "none of them", "one that leaves pixels whose channels are finite and not full", ""),
    ),
    (
        lambda: ir.map_thickness([[1.0], [1.0, 2.0]], OPEN),
        None,
        *("image", "[[1.0], [1.0, 2.0]]", "an array (height, width, 3)", ""),
    ),
    (
        lambda: ir.map_thickness(SEEN, OPEN, flat=np.ones((9, 9, 3))),
        "flat must have the size of the picture (40, 40), got (9, 9)",
        *("flat", "(9, 9)", "have the size of the picture (40, 40)", ""),
    ),
    (
        lambda: list(
            ir.map_thickness_video(
                [SEEN[:8, :8], SEEN[:9, :9]],
                OPEN,
                camera="srgb",
                illuminant="D65",
                noise=0.01,
                thickness_range_nm=(0.0, 300.0),
            )
        ),
        "frame 1 has (9, 9) pixels, those before (8, 8)",
        *("frames", "(9, 9)", "of one size, (8, 8)", "in frame 1"),
    ),
    (
        lambda: ir.map_thickness(SEEN, OPEN, camera="srgb", illuminant=INFRARED, thickness_range_nm=(0.0, 300.0)),
        "illuminant 'infrared' has no light from 380 to 780 nm",
        *("illuminant", "'infrared'", "a lamp with light from 380 to 780 nm", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", coupons=[(1.0, 20.0), (9.0, (50.0, 0.0, 0.0))]),
        None,
        *(
            "coupons",
            "[(1.0, 20.0), (9.0, (50.0, 0.0, 0.0))]",
            "a list of (volt, nm) or of (volt, (L, a, b)), all of one kind",
            "",
        ),
    ),
    (
        lambda: ir.recipes(
            [50, 0, 0], media=["SiO2"], substrate="Si", coupons=[(1.0, (50.0, 120.0, 0.0)), (9.0, (50.0, -120.0, 0.0))]
        ),
        "the colours of the coupons are not those of SiO2 of 0.3 to 6 nm a volt: the nearest line misses them by 20 "
        "(CIEDE2000)",
        *("coupons", "ones 20 (CIEDE2000) off", "of colours that SiO2 of 0.3 to 6 nm a volt has", ""),
    ),
    (
        lambda: ir.recipes([50, 0, 0], media=["SiO2"], substrate="Si", layers=1.5),
        None,
        *("layers", "1.5", "a list of 1, 2 and 3", ""),
    ),
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[2]} {case[3]}"[:40])
def test_a_refusal_has_its_parts_and_words(case: Case) -> None:
    check(case)


def test_a_folder_without_pictures_is_refused(tmp_path: Path) -> None:
    endings = ".exr, .npy, .tif, .tiff, .png, .jpg, .jpeg"
    words = f"{tmp_path}: no picture in it ({endings})"
    given = short(str(tmp_path))
    check(
        (
            lambda: ir.map_thickness_video(tmp_path, OPEN),
            words,
            *("frames", given, f"a folder with pictures ({endings})", ""),
        )
    )


def test_a_series_of_too_many_values_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    # (The limit itself is 1.6 GB.)
    monkeypatch.setattr(series_data, "_MOST_VALUES", 119)
    words = "spectra hold 120 values, at most 119 are taken: fit the series in parts"
    check((lambda: ir.fit_series(NM, [R, R], OPEN), words, *("spectra", "120", "119 values at most", "")))


def test_a_joint_fit_may_begin_at_no_thickness() -> None:
    # Rounding took the first trial below 0, and the fit was refused.
    power = ir.Measurement("reflectance", NM, R, gain=1.0, baseline="none")
    found = ir.fit_thickness(stack=OPEN, measurements=[power], thickness_range_nm=(0.0, 400.0))
    assert found.best.thickness_nm == pytest.approx(320.0, abs=0.1)
