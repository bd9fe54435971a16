"""Materials of glTF 2.0 as Mitsuba takes them: what a scene's files define, no more and no less.

Metal and roughness (appendix B of its specification): a Lambert base under a GGX surface of F0 0.04, mixed by Schlick's Fresnel, and metal mixed in
by its share. Mitsuba's own `principled` has Burley's diffuse base, which is up to 13 % brighter. And panes (KHR_materials_transmission)."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

_F0 = 0.04
#: Of which _F0 is what a pane mirrors squarely.
_PANE_IOR = 1.5
#: What of the samples goes to the base at least, and to the surface: either may be dark.
_LEAST = 0.1


class GltfMaterial(mi.BSDF):
    """Properties: base_color (texture), roughness, metallic. One side; within `twosided` both."""

    def __init__(self, properties: mi.Properties) -> None:
        mi.BSDF.__init__(self, properties)
        self.base, self.metallic = properties["base_color"], properties["metallic"]
        self.alpha = properties["roughness"] ** 2
        sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.SpatiallyVarying
        self.m_components = [mi.BSDFFlags.DiffuseReflection | sides, mi.BSDFFlags.GlossyReflection | sides]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def _surface(self) -> mi.MicrofacetDistribution:
        return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, True)

    def _share(self, base: Any, cosine: Any) -> Any:
        """Of the samples that go to the surface."""
        away = (1 - cosine) ** 5
        dielectric = _F0 + (1 - _F0) * away
        bright = mi.luminance(base)
        surface = self.metallic * (bright + (1 - bright) * away) + (1 - self.metallic) * dielectric
        return dr.clip(surface / dr.maximum(surface + (1 - self.metallic) * bright, 1e-6), _LEAST, 1 - _LEAST if self.metallic < 1 else 1.0)

    def _eval_pdf(self, si: Any, wo: Any, active: Any) -> tuple[Any, Any]:
        nv, nl = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active &= (nv > 0) & (nl > 0)
        half = dr.normalize(si.wi + wo)
        vh = dr.clip(dr.dot(si.wi, half), 0, 1)
        surface = self._surface()
        a2 = self.alpha**2
        visible = lambda cosine: cosine + dr.sqrt(a2 + (1 - a2) * cosine * cosine)
        specular = surface.eval(half) / (visible(nl) * visible(nv))
        away = (1 - vh) ** 5
        base = self.base.eval(si, active)
        dielectric = dr.lerp(base * dr.inv_pi, mi.Color3f(specular), _F0 + (1 - _F0) * away)
        value = dr.lerp(dielectric, specular * (base + (1 - base) * away), self.metallic) * nl
        share = self._share(base, nv)
        pdf = share * surface.pdf(si.wi, half) / dr.maximum(4 * vh, 1e-6) + (1 - share) * mi.warp.square_to_cosine_hemisphere_pdf(wo)
        return dr.select(active, value, 0), dr.select(active, pdf, 0)

    def eval(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self._eval_pdf(si, wo, active)[0]

    def pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self._eval_pdf(si, wo, active)[1]

    def eval_pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        return self._eval_pdf(si, wo, active)

    def sample(self, context: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
        nv = mi.Frame3f.cos_theta(si.wi)
        active &= nv > 0
        is_surface = sample1 < self._share(self.base.eval(si, active), nv)
        half = self._surface().sample(si.wi, sample2)[0]
        made = dr.zeros(mi.BSDFSample3f)
        made.wo = dr.select(is_surface, mi.reflect(si.wi, half), mi.warp.square_to_cosine_hemisphere(sample2))
        value, made.pdf = self._eval_pdf(si, made.wo, active)
        made.eta = 1.0
        made.sampled_type = dr.select(is_surface, mi.UInt32(+mi.BSDFFlags.GlossyReflection), mi.UInt32(+mi.BSDFFlags.DiffuseReflection))
        made.sampled_component = dr.select(is_surface, mi.UInt32(1), mi.UInt32(0))
        is_good = active & (made.pdf > 0)
        return made, dr.select(is_good, value / dr.maximum(made.pdf, 1e-30), 0)

    def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
        """The file's colour, of metal too: what guides a denoiser."""
        return self.base.eval(si, active)

    def traverse(self, callback: Any) -> None:
        callback.put("base_color", self.base, mi.ParamFlags.Differentiable)

    def to_string(self) -> str:
        return f"GltfMaterial[alpha={self.alpha}, metallic={self.metallic}]"


class GltfPane(mi.BSDF):
    """A thin smooth pane. Properties: base_color (rgb), transmission: the share of what enters that goes straight through, in that colour; the base
    scatters the rest. Its two sides mirror by Fresnel's equations, also among each other."""

    def __init__(self, properties: mi.Properties) -> None:
        mi.BSDF.__init__(self, properties)
        self.base, self.transmission = mi.Color3f(properties["base_color"]), properties["transmission"]
        sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [kind | sides for kind in (mi.BSDFFlags.DiffuseReflection, mi.BSDFFlags.DeltaReflection, mi.BSDFFlags.Null)]
        self.m_flags = self.m_components[0] | self.m_components[1] | self.m_components[2]

    def _mirrored(self, si: Any) -> Any:
        one_side = mi.fresnel(dr.abs(mi.Frame3f.cos_theta(si.wi)), _PANE_IOR)[0]
        return 2 * one_side / (1 + one_side)

    def eval_pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
        cosine = mi.Frame3f.cos_theta(wo)
        scattered = (1 - self._mirrored(si)) * (1 - self.transmission)
        active &= cosine * mi.Frame3f.cos_theta(si.wi) > 0
        pdf = scattered * dr.abs(cosine) * dr.inv_pi
        return dr.select(active, self.base * pdf, 0), dr.select(active, pdf, 0)

    def eval(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.eval_pdf(context, si, wo, active)[0]

    def pdf(self, context: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.eval_pdf(context, si, wo, active)[1]

    def eval_null_transmission(self, si: Any, active: Any = True) -> Any:
        return self.base * ((1 - self._mirrored(si)) * self.transmission)

    def sample(self, context: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> tuple[Any, Any]:
        mirrored = self._mirrored(si)
        through = (1 - mirrored) * self.transmission
        is_mirrored, is_through = sample1 < mirrored, (sample1 >= mirrored) & (sample1 < mirrored + through)
        made = dr.zeros(mi.BSDFSample3f)
        spread = mi.warp.square_to_cosine_hemisphere(sample2)
        spread.z = dr.copysign(spread.z, mi.Frame3f.cos_theta(si.wi))
        made.wo = dr.select(is_mirrored, mi.reflect(si.wi), dr.select(is_through, -si.wi, spread))
        scattered = (1 - mirrored - through) * dr.abs(spread.z) * dr.inv_pi
        made.pdf = dr.select(is_mirrored, mirrored, dr.select(is_through, through, scattered))
        made.eta = 1.0
        kinds = (mi.BSDFFlags.DeltaReflection, mi.BSDFFlags.Null, mi.BSDFFlags.DiffuseReflection)
        of_mirror, of_through, of_base = (mi.UInt32(+kind) for kind in kinds)
        made.sampled_type = dr.select(is_mirrored, of_mirror, dr.select(is_through, of_through, of_base))
        made.sampled_component = dr.select(is_mirrored, mi.UInt32(1), dr.select(is_through, mi.UInt32(2), mi.UInt32(0)))
        return made, dr.select(active & (made.pdf > 0), dr.select(is_mirrored, mi.Color3f(1), self.base), 0)

    def eval_diffuse_reflectance(self, si: Any, active: Any = True) -> Any:
        return self.base * (1 - self.transmission)

    def traverse(self, callback: Any) -> None:
        pass

    def to_string(self) -> str:
        return f"GltfPane[transmission={self.transmission}]"


mi.register_bsdf("camrig_gltf", lambda properties: GltfMaterial(properties))
mi.register_bsdf("camrig_gltf_pane", lambda properties: GltfPane(properties))
