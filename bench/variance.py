"""The plane `variance` against the variance that other seeds show: told over true, at 48 x 32.

python bench/variance.py [--seeds 24]
"""

from __future__ import annotations

import argparse
import warnings

import numpy as np

import iridesce as ir

SCENES = ("soap-bubble", "oil-slick", "newtons-rings", "titanium")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=24)
    seeds = parser.parse_args().seeds
    warnings.simplefilter("ignore")  # media whose data stop inside the visible range
    print("scene, samples, median of told / true, pixels within 3 of the told sigma")
    for scene in SCENES:
        for samples in (16, 64):
            images = [ir.render(scene, size=(48, 32), samples=samples, seed=seed) for seed in range(seeds)]
            y = np.stack([image.xyz[..., 1].astype(float) for image in images])
            told = np.mean([image.channels["variance"] for image in images], axis=0)
            true = y.var(axis=0, ddof=1)
            noisy = (true > 0.0) & (told > 0.0)
            within = np.abs(y[0] - y.mean(axis=0)) <= 3.0 * np.sqrt(told)
            print(f"{scene} {samples} {np.median(told[noisy] / true[noisy]):.2f} {within.mean():.4f}")


if __name__ == "__main__":
    main()
