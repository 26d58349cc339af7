"""Compute ``crates/optics/data/observers/rgb_basis.csv``: the three smooth functions that turn linear RGB into light.

    pip install numpy scipy clarabel
    python tools/data/rgb_basis.py

f_R, f_G, f_B at 1 nm, 360..830 nm, minimise the summed squares of their second differences subject to

    f_j >= 0,   f_R + f_G + f_B = 1 at every wavelength,
    M sum(D65 f_j cmf) / sum(D65 ybar) = w_j e_j,

with cmf of CIE 1931, D65 its 5 nm table (linear between, zero outside), M the matrix from XYZ to linear Rec.709 derived
from its primaries and the white (0.3127, 0.3290), and w = M XYZ(D65 table): because the table's white is not quite
(0.3127, 0.3290), w differs from (1, 1, 1) by about 2e-4, and only so can grey be D65 itself.
The idea of such a decomposition is that of I. Mallett and C. Yuksel, "Spectral primary decomposition for rendering with
sRGB reflectance", EGSR 2019 (doi:10.2312/sr.20191216); this is a computation of our own on another grid and white.
"""

from __future__ import annotations

import csv
from pathlib import Path

import clarabel
import numpy as np
from scipy import sparse

DATA = Path(__file__).resolve().parents[2] / "crates" / "optics" / "data"
NM = np.arange(360, 831)
PRIMARIES = np.array([[0.640, 0.330], [0.300, 0.600], [0.150, 0.060]])
WHITE = np.array([0.3127, 0.3290])


def rows(name: str) -> list[dict[str, str]]:
    lines = [line for line in (DATA / name).read_text().splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


def rgb_from_xyz() -> np.ndarray:
    def xyz(xy: np.ndarray) -> np.ndarray:
        return np.array([xy[0] / xy[1], 1.0, (1.0 - xy[0] - xy[1]) / xy[1]])

    columns = np.stack([xyz(p) for p in PRIMARIES], axis=1)
    return np.linalg.inv(columns * np.linalg.solve(columns, xyz(WHITE)))


def main() -> None:
    cmf = np.array([[float(r[k]) for k in ("xbar", "ybar", "zbar")] for r in rows("observers/cie1931.csv")])
    table = [(float(r["wavelength_nm"]), float(r["D65"])) for r in rows("illuminants/cie_illuminants.csv") if r["D65"]]
    light = np.interp(NM, *zip(*table, strict=True), left=0.0, right=0.0)
    weights = rgb_from_xyz() @ (light[:, None] * cmf / (light @ cmf[:, 1])).T  # (3, 471): RGB of a unit at each nm
    white = weights.sum(axis=1)

    size = len(NM)
    second = sparse.diags([1.0, -2.0, 1.0], [0, 1, 2], shape=(size - 2, size))
    quadratic = sparse.block_diag([second.T @ second] * 3, format="csc")
    one = sparse.eye(size)
    equalities = sparse.vstack([sparse.block_diag([weights] * 3), sparse.hstack([one, one, one])])
    wanted = np.concatenate([np.diag(white).T.ravel(), np.ones(size)])
    # f_R + f_G + f_B = 1 makes the last three colour equalities follow from the first six: drop them.
    keep = np.r_[0:6, 9 : 9 + size]
    equalities, wanted = equalities.tocsr()[keep], wanted[keep]
    matrix = sparse.vstack([equalities, -sparse.eye(3 * size)], format="csc")
    bound = np.concatenate([wanted, np.zeros(3 * size)])
    cones = [clarabel.ZeroConeT(len(wanted)), clarabel.NonnegativeConeT(3 * size)]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-13
    scale = 1e4  # second differences are small; the solver's stopping rule is absolute
    problem = clarabel.DefaultSolver(
        sparse.triu(quadratic * scale, format="csc"), np.zeros(3 * size), matrix, bound, cones, settings
    )
    solution = problem.solve()
    f = np.array(solution.x).reshape(3, size)
    # An interior point stays a hair inside its bounds: put it on them, and let the largest of the three fill the sum.
    f = np.where(f < 1e-9, 0.0, f).round(12)
    top = f.argmax(axis=0)
    f[top, np.arange(size)] += 1.0 - f.sum(axis=0)
    print(solution.status, "worst colour error", np.abs(weights @ f.T - np.diag(white)).max(), "white", white)

    lines = [
        "# Basis of light for linear Rec.709 under D65; written by tools/data/rgb_basis.py",
        "wavelength_nm,f_r,f_g,f_b",
    ]
    lines += [f"{nm}," + ",".join(f"{v:.12f}" for v in f[:, i]) for i, nm in enumerate(NM)]
    (DATA / "observers" / "rgb_basis.csv").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
