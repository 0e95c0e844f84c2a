"""Uniform suspensions of equal spheres: how fast they settle, or which velocity expands them how far, by Richardson & Zaki and by the drag laws; and
the void fraction of a slab by the exact volumes of its spheres.

J. F. Richardson & W. N. Zaki, Trans. Inst. Chem. Eng. 32 (1954) 35-53: U = U_t eps^n of the superficial velocity, n by the Reynolds number of a
lone sphere's fall. A. R. Khan & J. F. Richardson, Chem. Eng. Commun. 78 (1989) 111-130: n by the Archimedes number.
L. Schiller & A. Naumann (1935): the lone sphere's drag; 0.44 from Re = 1000 on.
"""
import numpy as np

G = 9.81


def drag_coefficient(Re):
    return np.where(Re < 1000, 24 / np.maximum(Re, 1e-12) * (1 + 0.15 * Re**0.687), 0.44)


def by_bisection(rises, low, high):
    """Where a rising function is 0, on a logarithmic scale."""
    for _ in range(100):
        middle = np.sqrt(low * high)
        low, high = (middle, high) if rises(middle) < 0 else (low, middle)
    return middle


def terminal_velocity(d, rho_p, rho_f, mu):
    """Of a lone sphere (m/s)."""
    weight = np.pi / 6 * d**3 * (rho_p - rho_f) * G
    return by_bisection(lambda U: np.pi / 8 * d**2 * rho_f * U**2 * drag_coefficient(rho_f * U * d / mu) - weight, 1e-9, 1e3)


def richardson_zaki(Re):
    """Their exponent n, walls far away, by the Reynolds number of a lone sphere's fall."""
    return 4.65 if Re < 0.2 else 4.35 * Re**-0.03 if Re < 1 else 4.45 * Re**-0.1 if Re < 500 else 2.39


def khan_richardson(archimedes):
    """n by the Archimedes number, walls far away: (4.8 - n)/(n - 2.4) = 0.043 Ar^0.57."""
    a = 0.043 * archimedes**0.57
    return (4.8 + 2.4 * a) / (1 + a)


def by_law(law, eps, d, rho_p, rho_f, mu):
    """Superficial velocity (m/s) at which a law of drag_check.LAWS holds the suspension: beta (U/eps) = eps (1 - eps)(rho_p - rho_f) g."""
    wanted = eps * (1 - eps) * (rho_p - rho_f) * G
    return by_bisection(lambda U: law(eps, rho_f * U * d / mu) * mu / d**2 * U / eps - wanted, 1e-9, 1e3)


def void_by_law(law, U, d, rho_p, rho_f, mu):
    """The void fraction to which the velocity U expands a bed by a law."""
    low, high = 0.2, 0.999
    for _ in range(60):
        eps = 0.5 * (low + high)
        low, high = (eps, high) if by_law(law, eps, d, rho_p, rho_f, mu) < U else (low, eps)
    return eps


def volume_below(z, centre, radius):
    """Volume of spheres below the height z (m3): caps by their height h, pi h^2 (3 r - h)/3."""
    h = np.clip(z - (centre - radius), 0, 2 * radius)
    return np.sum(np.pi * h**2 * (3 * radius - h) / 3)


def void_between(low, high, centre, radius, section):
    """Void fraction of the slab between two heights."""
    return 1 - (volume_below(high, centre, radius) - volume_below(low, centre, radius)) / (section * (high - low))
