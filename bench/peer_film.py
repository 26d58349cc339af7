"""An exact film for Mitsuba 3 as a polarised BSDF, smooth or rough: the peer of bench/validation.py.

Tables of Mueller numbers over thickness, wavelength and angle are made by `ir.Stack`; Mitsuba has no film of its own.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: First and last nm and their number: titanium dioxide ends at 826 nm, where no eye sees.
BANDS = (360.0, 825.0, 94)


def alpha_of(tree: dict[str, Any]) -> tuple[float, float] | None:
    """GGX alphas of a rough coating; None for all else."""
    ((kind, keys),) = tree["object"][0]["surface"].items()
    roughness = keys.get("roughness", 0.0)
    if kind != "coating" or not roughness:
        return None
    along_u, along_v = roughness if isinstance(roughness, list) else (roughness, roughness)
    return along_u**2, along_v**2


def table_of(surface: dict[str, Any]) -> dict[str, Any]:
    """Mueller numbers of a film over thickness, wavelength and cosine: of reflection and passage each Ms, Mp, Re and Im of s p*.

    In the signs of iridesce, which are those of Mitsuba's Mueller matrices but for Im, whose place says it.
    """
    import iridesce as ir

    ((kind, keys),) = surface.items()
    thickness: Any = np.zeros((1, 1, 1))
    base, low, high = 1.0, 0.0, 0.0
    if kind == "film":
        law = keys["thickness_nm"]
        if isinstance(law, dict):
            low, high = law["gradient"]["bottom"], law["gradient"]["top"]
            thickness = np.linspace(low, high, 141)[:, None, None]
        else:
            thickness = np.full((1, 1, 1), float(law))
        items: list[Any] = ["air", ir.Layer(keys["medium"], thickness), "air"]
    else:
        layers = [ir.Layer(row["medium"], row["thickness_nm"]) for row in keys.get("layers", [])]
        last = keys.get("substrate", keys.get("medium"))
        last = complex(*last) if isinstance(last, list) else last
        items = ["air", *layers, last]
        base = float(last) if isinstance(last, float) else 0.0  # what is no number is opaque here
    stack = ir.Stack(items)
    wavelength = np.linspace(*BANDS)[None, :, None]
    cosine = np.linspace(0.0, 1.0, 192)
    angle = np.degrees(np.arccos(np.clip(cosine, 1e-4, 1.0)))[None, None, :]

    def numbers(stack: Any, angle: Any) -> Floats:
        (rs, ts), (rp, tp) = (stack.amplitudes(wavelength, angle, of) for of in "sp")
        power = [
            getattr(stack, which)(wavelength, angle, of) for which in ("reflectance", "transmittance") for of in "sp"
        ]
        turn = [rs * np.conj(rp), ts * np.conj(tp)]
        phase = [z / np.maximum(np.abs(z), 1e-30) for z in turn]
        both = [np.sqrt(power[0] * power[1]), np.sqrt(power[2] * power[3])]
        rows = [power[0], power[1], both[0] * phase[0].real, both[0] * phase[0].imag]
        rows += [power[2], power[3], both[1] * phase[1].real, both[1] * phase[1].imag]
        shape = np.broadcast_shapes(thickness.shape, wavelength.shape, cosine.shape)
        return np.stack([np.broadcast_to(row, shape) for row in rows]).astype(np.float32)

    from_within = numbers(stack, angle) if base == 1.0 else None
    if base > 1.0:
        # By the cosine within: beyond the critical angle all is mirrored, and the phases of s and p part.
        from_within = numbers(stack.reversed(), angle)
    return {"outside": numbers(stack, angle), "inside": from_within, "base": base, "low": low, "high": high}


def exact_film(mi: Any) -> Any:
    """A film as a polarised BSDF: smooth, or GGX facets of which each answers as the exact film at its own angle.

    Facets: seen normals, Smith's shadowing, height-correlated; what a second facet would mirror is lost, as in Mitsuba's own.
    """
    import drjit as dr

    class ExactFilm(mi.BSDF):  # type: ignore[misc, name-defined]
        def __init__(self) -> None:
            mi.BSDF.__init__(self, mi.Properties("exact_film"))
            self.m_flags, self.m_components = mi.BSDFFlags.Empty, []

        def tell(self, table: dict[str, Any], alpha: tuple[float, float] | None) -> None:
            self.base, self.low, self.high = table["base"], table["low"], table["high"]
            self.shape = table["outside"].shape[1:]
            self.numbers = [
                [mi.Float(part.ravel()) for part in table[side]] if table[side] is not None else []
                for side in ("outside", "inside")
            ]
            self.facets = alpha and mi.MicrofacetDistribution(mi.MicrofacetType.GGX, alpha[0], alpha[1], True)
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            mirrored = mi.BSDFFlags.DeltaReflection | sides
            passed = (mi.BSDFFlags.Null if self.base == 1.0 else mi.BSDFFlags.DeltaTransmission) | sides
            self.m_components = [mirrored, passed] if self.base else [mirrored]
            if alpha:
                self.m_components = [mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.Anisotropic]
            self.m_flags = self.m_components[0] | (self.m_components[1] if self.base else 0)

        def _at(self, side: int, part: int, si: Any, cosine: Any, active: Any) -> Any:
            """One number of a table, linear between its entries."""
            steps, bands, rows = self.shape
            share = (
                (self.low + (self.high - self.low) * (0.5 + 0.5 * si.p.y) - self.low) / (self.high - self.low)
                if steps > 1
                else 0.0
            )
            t = dr.clip(mi.Float(share), 0, 1) * (steps - 1)
            c = dr.clip(cosine, 0, 1) * (rows - 1)
            t0, c0 = dr.minimum(mi.UInt32(t), max(steps - 2, 0)), dr.minimum(mi.UInt32(c), rows - 2)
            t1 = dr.minimum(t0 + 1, steps - 1)
            dt, dc = t - mi.Float(t0), c - mi.Float(c0)
            result = mi.UnpolarizedSpectrum(0)
            table = self.numbers[side][part]
            for band in range(len(si.wavelengths)):
                w = dr.clip((si.wavelengths[band] - BANDS[0]) / (BANDS[1] - BANDS[0]), 0, 1) * (bands - 1)
                w0 = dr.minimum(mi.UInt32(w), bands - 2)
                dw = w - mi.Float(w0)

                def at(i: Any, j: Any) -> Any:
                    place = (i * bands + j) * rows + c0
                    return dr.lerp(
                        dr.gather(mi.Float, table, place, active), dr.gather(mi.Float, table, place + 1, active), dc
                    )

                result[band] = dr.lerp(
                    dr.lerp(at(t0, w0), at(t0, w0 + 1), dw), dr.lerp(at(t1, w0), at(t1, w0 + 1), dw), dt
                )
            return result

        def _both(self, first: int, si: Any, cosine: Any, outside: Any, active: Any) -> list[Any]:
            """Ms, Mp, Re, Im from the side that the light comes from."""
            told = [self._at(0, first + part, si, cosine, active) for part in range(4)]
            if not self.numbers[1]:
                return told
            return [
                dr.select(outside, one, self._at(1, first + part, si, cosine, active)) for part, one in enumerate(told)
            ]

        def _mueller(self, numbers: list[Any], ctx: Any, wi: Any, wo: Any, h: Any) -> Any:
            """The matrix about the plane of incidence on h, turned into Mitsuba's own frames of the two rays."""
            s, p, re, im = numbers
            a, b = 0.5 * (s + p), 0.5 * (s - p)
            if not mi.is_polarized:
                return a
            o = mi.UnpolarizedSpectrum(0)
            matrix = mi.Spectrum(a, b, o, o, b, a, o, o, o, o, re, -im, o, o, im, re)
            goes, comes = (wo, wi) if ctx.mode == mi.TransportMode.Radiance else (wi, wo)
            s_in, s_out = dr.cross(h, -goes), dr.cross(h, comes)
            flat = dr.squared_norm(s_in) < 1e-12
            s_in = dr.select(flat, mi.Vector3f(1, 0, 0), dr.normalize(s_in))
            s_out = dr.select(flat, mi.Vector3f(1, 0, 0), dr.normalize(s_out))
            return mi.mueller.rotate_mueller_basis(
                matrix, -goes, s_in, mi.mueller.stokes_basis(-goes), comes, s_out, mi.mueller.stokes_basis(comes)
            )

        def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> Any:
            bs = mi.BSDFSample3f()
            cos_in = mi.Frame3f.cos_theta(si.wi)
            bs.eta = mi.Float(1)
            bs.sampled_component = mi.UInt32(0)
            if self.facets:
                h, _ = self.facets.sample(si.wi, sample2)
                bs.wo = mi.reflect(si.wi, h)
                bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
                bs.pdf = self.pdf(ctx, si, bs.wo, active)
                value = self.eval(ctx, si, bs.wo, active) / dr.maximum(bs.pdf, 1e-12)
                return bs, value & (active & (bs.pdf > 0))
            outside, cosine, n = cos_in > 0, dr.abs(cos_in), mi.Vector3f(0, 0, 1)
            mirror = self._both(0, si, cosine, outside, active)
            if not self.base:
                bs.wo = mi.reflect(si.wi)
                bs.pdf = mi.Float(1)
                bs.sampled_type = mi.UInt32(+mi.BSDFFlags.DeltaReflection)
                return bs, self._mueller(mirror, ctx, si.wi, bs.wo, n) & (active & outside)
            passes = self._both(4, si, cosine, outside, active)
            share = [dr.mean(each[0] + each[1]) for each in (mirror, passes)]
            chance = dr.clip(share[0] / dr.maximum(share[0] + share[1], 1e-9), 0.001, 0.999)
            chance = dr.select(share[1] <= 0, 1, chance)
            is_mirror = sample1 <= chance
            ratio = dr.select(outside, 1 / self.base, self.base)
            cos_out = dr.sqrt(dr.maximum(1 - ratio * ratio * (1 - cosine * cosine), 0))
            bent = mi.Vector3f(-si.wi.x * ratio, -si.wi.y * ratio, -dr.sign(cos_in) * cos_out)
            bs.wo = dr.select(is_mirror, mi.reflect(si.wi), bent)
            bs.eta = dr.select(is_mirror, 1, 1 / ratio)
            bs.pdf = dr.select(is_mirror, chance, 1 - chance)
            through = +(mi.BSDFFlags.Null if self.base == 1.0 else mi.BSDFFlags.DeltaTransmission)
            bs.sampled_type = dr.select(is_mirror, mi.UInt32(+mi.BSDFFlags.DeltaReflection), mi.UInt32(through))
            bs.sampled_component = dr.select(is_mirror, mi.UInt32(0), mi.UInt32(1))
            chosen = [dr.select(is_mirror, a, b) for a, b in zip(mirror, passes, strict=True)]
            # Radiance is squeezed where it is bent, by the square of the ratio of the indices.
            squeeze = dr.select(is_mirror, 1, ratio * ratio)
            value = self._mueller(chosen, ctx, si.wi, bs.wo, n) * (squeeze / dr.maximum(bs.pdf, 1e-9))
            return bs, value & active

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            if not self.facets:
                return mi.Spectrum(0)
            cos_in, cos_out = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
            active = active & (cos_in > 0) & (cos_out > 0)
            h = dr.normalize(si.wi + wo)
            seen, lit = self.facets.smith_g1(si.wi, h), self.facets.smith_g1(wo, h)
            both = seen * lit
            shadowing = dr.select(both > 0, both / dr.maximum(seen + lit - both, 1e-9), 0)
            numbers = self._both(0, si, dr.dot(si.wi, h), True, active)
            value = self._mueller(numbers, ctx, si.wi, wo, h) * (
                self.facets.eval(h) * shadowing / (4 * dr.maximum(cos_in, 1e-9))
            )
            return value & active

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            if not self.facets:
                return mi.Float(0)
            h = dr.normalize(si.wi + wo)
            density = self.facets.pdf(si.wi, h) / (4 * dr.maximum(dr.dot(wo, h), 1e-9))
            return dr.select((mi.Frame3f.cos_theta(si.wi) > 0) & (mi.Frame3f.cos_theta(wo) > 0), density, 0)

        def eval_null_transmission(self, si: Any, active: Any = True) -> Any:
            if self.facets or self.base != 1.0:
                return mi.Spectrum(0)
            cosine = mi.Frame3f.cos_theta(si.wi)
            passes = self._both(4, si, dr.abs(cosine), cosine > 0, active)
            return self._mueller(passes, mi.BSDFContext(), si.wi, -si.wi, mi.Vector3f(0, 0, 1)) & active

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

        def traverse(self, callback: Any) -> None:
            pass

        def to_string(self) -> str:
            return "ExactFilm[]"

    return ExactFilm()
