"""Indices of refraction by Mitsuba's names: of dielectrics, and of metals as complex numbers in linear sRGB.

Dielectrics were measured near 589 nm (mostly Hecht, *Optics*, 4th edition). The measurements of metals come from
luxpop.com's collection (*SOPRA*; names that end in ``_palik``: Palik, *Handbook of Optical Constants of Solids*), as
distributed with Mitsuba. Each measured curve is linear between its points. It is integrated against the CIE 1931
observer under an illuminant of equal energy; curves of reflectance are integrated under D65 instead. Negative channels
(outside the gamut) become zero, as in Mitsuba 3's RGB mode.
"""

from __future__ import annotations

from typing import NamedTuple

from equaltime.scene.model.values import Color
from equaltime.words import suggestion

__all__ = ["IOR", "METALS", "Metal", "as_ior", "as_metal"]

IOR = {
    "vacuum": 1.0,
    "helium": 1.000036,
    "hydrogen": 1.000132,
    "air": 1.000277,
    "carbon dioxide": 1.00045,
    "water": 1.3330,
    "acetone": 1.36,
    "ethanol": 1.361,
    "carbon tetrachloride": 1.461,
    "glycerol": 1.4729,
    "benzene": 1.501,
    "silicone oil": 1.52045,
    "bromine": 1.661,
    "water ice": 1.31,
    "fused quartz": 1.458,
    "pyrex": 1.470,
    "acrylic glass": 1.49,
    "polypropylene": 1.49,
    "bk7": 1.5046,
    "sodium chloride": 1.544,
    "amber": 1.55,
    "pet": 1.5750,
    "diamond": 2.419,
}


def as_ior(value: object) -> object:
    """Return the index of refraction of the material named `value`, such as ``water``.

    A `value` that is not a string is returned unchanged. Raises ValueError for an unknown name.
    """
    if not isinstance(value, str):
        return value
    try:
        return IOR[value.lower()]
    except KeyError:
        raise ValueError(f"expected a number or a material, found {value!r}{suggestion(value, IOR)}") from None


class Metal(NamedTuple):
    """Complex index of refraction of a metal: real part ``eta`` and extinction ``k``, per channel."""

    eta: Color
    k: Color


def as_metal(value: object) -> object:
    """Return the name of a metal in its proper case: ``Au`` for ``au``. The name ``none`` is allowed, too.

    A `value` that is not a string is returned unchanged. Raises ValueError for an unknown name.
    """
    if not isinstance(value, str) or value in METALS:
        return value
    proper = {name.lower(): name for name in ("none", *METALS)}
    if value.lower() not in proper:
        raise ValueError(f"expected 'none' or a metal, found {value!r}{suggestion(value, METALS)}")
    return proper[value.lower()]


METALS = {
    "Ag": Metal((0.155276, 0.116728, 0.138388), (4.82835, 3.12222, 2.1469)),
    "Al": Metal((1.6575, 0.880405, 0.521244), (9.22381, 6.2695, 4.837)),
    "AlAs": Metal((3.6053, 3.23294, 2.21632), (0.000679437, 0.0, 0.00751271)),
    "AlAs_palik": Metal((3.6053, 3.23294, 2.21632), (0.000679437, 0.0, 0.00751271)),
    "AlSb": Metal((0.0, 4.13937, 4.66925), (0.0, 0.0940091, 1.30057)),
    "AlSb_palik": Metal((0.0, 4.13937, 4.66925), (0.0, 0.0940091, 1.30057)),
    "Au": Metal((0.143036, 0.375307, 1.44205), (3.983, 2.38556, 1.60336)),
    "Be": Metal((4.18501, 3.18503, 2.78406), (3.83547, 3.01012, 2.86899)),
    "Be_palik": Metal((4.18501, 3.18503, 2.78406), (3.83547, 3.01012, 2.86899)),
    "Cr": Metal((4.36967, 2.91651, 1.6549), (5.20655, 4.23131, 3.7547)),
    "CsI": Metal((2.1449, 1.70232, 1.66243), (0.0, 0.0, 0.0)),
    "CsI_palik": Metal((2.1449, 1.70232, 1.66243), (0.0, 0.0, 0.0)),
    "Cu": Metal((0.201005, 0.92375, 1.10222), (3.91326, 2.45305, 2.14209)),
    "Cu2O": Metal((3.55177, 2.94987, 2.75188), (0.114207, 0.193897, 0.606134)),
    "Cu2O_palik": Metal((3.55177, 2.94987, 2.75188), (0.114207, 0.193897, 0.606134)),
    "CuO": Metal((3.24754, 2.44781, 2.21022), (0.52109, 0.570031, 0.722179)),
    "CuO_palik": Metal((3.24754, 2.44781, 2.21022), (0.52109, 0.570031, 0.722179)),
    "Cu_palik": Metal((0.213229, 0.919715, 1.10241), (3.92187, 2.45733, 2.13658)),
    "Hg": Metal((2.39894, 1.44003, 0.90957), (6.32759, 4.37192, 3.42176)),
    "HgTe": Metal((4.77904, 3.2312, 2.6599), (1.63161, 1.58081, 1.72929)),
    "HgTe_palik": Metal((4.77904, 3.2312, 2.6599), (1.63161, 1.58081, 1.72929)),
    "Hg_palik": Metal((2.39894, 1.44003, 0.90957), (6.32759, 4.37192, 3.42176)),
    "Ir": Metal((3.0863, 2.08219, 1.61791), (5.59215, 4.06709, 3.26731)),
    "Ir_palik": Metal((3.0863, 2.08219, 1.61791), (5.59215, 4.06709, 3.26731)),
    "K": Metal((0.0640432, 0.0464098, 0.0381849), (2.1042, 1.34894, 0.913126)),
    "K_palik": Metal((0.0640432, 0.0464098, 0.0381849), (2.1042, 1.34894, 0.913126)),
    "Li": Metal((0.265791, 0.195618, 0.220949), (3.54015, 2.31112, 1.66861)),
    "Li_palik": Metal((0.265791, 0.195618, 0.220949), (3.54015, 2.31112, 1.66861)),
    "MgO": Metal((2.08958, 1.65072, 1.59488), (4.3327e-12, 0.0, 2.49865e-11)),
    "MgO_palik": Metal((2.08958, 1.65072, 1.59488), (4.3327e-12, 0.0, 2.49865e-11)),
    "Mo": Metal((4.48397, 3.52513, 2.77631), (4.11144, 3.42083, 3.15061)),
    "Mo_palik": Metal((4.48397, 3.52513, 2.77631), (4.11144, 3.42083, 3.15061)),
    "Na_palik": Metal((0.0602694, 0.0561409, 0.0619884), (3.17927, 2.11249, 1.57904)),
    "Nb": Metal((3.42007, 2.79009, 2.39563), (3.44139, 2.73767, 2.57975)),
    "Nb_palik": Metal((3.42007, 2.79009, 2.39563), (3.44139, 2.73767, 2.57975)),
    "Ni_palik": Metal((2.3673, 1.66337, 1.46708), (4.49881, 3.05015, 2.34544)),
    "Rh": Metal((2.58579, 1.86022, 1.55426), (6.78226, 4.70299, 3.97607)),
    "Rh_palik": Metal((2.58579, 1.86022, 1.55426), (6.78226, 4.70299, 3.97607)),
    "Se": Metal((4.05831, 2.84294, 2.82085), (0.75405, 0.638444, 0.521808)),
    "Se-e": Metal((5.72285, 4.16574, 4.08134), (0.871136, 1.10516, 1.56532)),
    "Se-e_palik": Metal((5.72285, 4.16574, 4.08134), (0.871136, 1.10516, 1.56532)),
    "Se_palik": Metal((4.05831, 2.84294, 2.82085), (0.75405, 0.638444, 0.521808)),
    "SiC": Metal((3.17234, 2.52597, 2.47937), (7.53766e-07, 0.0, 1.01925e-05)),
    "SiC_palik": Metal((3.17234, 2.52597, 2.47937), (7.53766e-07, 0.0, 1.01925e-05)),
    "SnTe": Metal((4.52425, 1.98164, 1.28159), (0.0, 0.0, 0.0)),
    "SnTe_palik": Metal((4.52425, 1.98164, 1.28159), (0.0, 0.0, 0.0)),
    "Ta": Metal((2.06272, 2.39294, 2.62793), (2.40836, 1.74149, 1.94703)),
    "Ta_palik": Metal((2.06272, 2.39294, 2.62793), (2.40836, 1.74149, 1.94703)),
    "Te": Metal((7.39023, 4.4821, 2.63711), (3.25602, 3.52706, 3.29205)),
    "Te-e": Metal((7.50891, 4.29643, 2.36999), (5.58393, 4.94721, 3.99759)),
    "Te-e_palik": Metal((7.50891, 4.29643, 2.36999), (5.58393, 4.94721, 3.99759)),
    "Te_palik": Metal((7.39023, 4.4821, 2.63711), (3.25602, 3.52706, 3.29205)),
    "ThF4": Metal((1.83071, 1.44223, 1.38765), (0.0, 0.0, 0.0)),
    "ThF4_palik": Metal((1.83071, 1.44223, 1.38765), (0.0, 0.0, 0.0)),
    "TiC": Metal((3.70053, 2.83742, 2.58229), (3.26564, 2.35159, 2.17279)),
    "TiC_palik": Metal((3.70053, 2.83742, 2.58229), (3.26564, 2.35159, 2.17279)),
    "TiN": Metal((1.64845, 1.15052, 1.37982), (3.36833, 1.9435, 1.10207)),
    "TiN_palik": Metal((1.64845, 1.15052, 1.37982), (3.36833, 1.9435, 1.10207)),
    "TiO2": Metal((3.45661, 2.80174, 2.90517), (0.000105265, 0.0, 0.000652887)),
    "TiO2-e": Metal((3.10656, 2.51317, 2.58244), (2.97516e-05, 0.0, 0.000182698)),
    "TiO2-e_palik": Metal((3.10656, 2.51317, 2.58244), (2.97516e-05, 0.0, 0.000182698)),
    "TiO2_palik": Metal((3.45661, 2.80174, 2.90517), (0.000105265, 0.0, 0.000652887)),
    "VC": Metal((3.65757, 2.75274, 2.53267), (3.0683, 2.19869, 1.96319)),
    "VC_palik": Metal((3.65757, 2.75274, 2.53267), (3.0683, 2.19869, 1.96319)),
    "VN": Metal((2.8656, 2.11919, 1.94009), (3.03224, 2.05612, 1.61631)),
    "VN_palik": Metal((2.8656, 2.11919, 1.94009), (3.03224, 2.05612, 1.61631)),
    "V_palik": Metal((4.27758, 3.51295, 2.76107), (3.4913, 2.88945, 3.11152)),
    "W": Metal((4.37082, 3.30025, 2.99841), (3.50064, 2.60487, 2.27323)),
    "a-C": Metal((2.94405, 2.22714, 1.96816), (0.887465, 0.799299, 0.81529)),
    "d-C": Metal((2.70872, 2.31883, 2.2289), (0.0, 0.0, 0.0)),
    "d-C_palik": Metal((2.70872, 2.31883, 2.2289), (0.0, 0.0, 0.0)),
}
