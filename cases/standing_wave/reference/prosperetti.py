"""Amplitude of a small standing wave between two fluids of one kinematic viscosity, from rest.

A. Prosperetti, Phys. Fluids 24 (1981) 1217:
  a/a0 = 4(1-4b) n^2/(8(1-4b) n^2 + w0^2) erfc(sqrt(n t))
       + sum_i z_i/Z_i w0^2/(z_i^2 - n) exp((z_i^2 - n) t) erfc(z_i sqrt(t)),
with n = nu k^2, b = rho1 rho2/(rho1 + rho2)^2, w0^2 = sigma k^3/(rho1 + rho2) (no gravity), z_i the roots of
  z^4 - 4 b sqrt(n) z^3 + 2(1-6b) n z^2 + 4(1-3b) n^(3/2) z + (1-4b) n^2 + w0^2 = 0
and Z_i the product of z_j - z_i over j != i. Checked here: a(0) = a0, a'(0) = 0.
"""
import numpy as np


def wofz(z, n=48):
    """Faddeeva's w(z) = exp(-z^2) erfc(-i z) by J. A. C. Weideman, SIAM J. Numer. Anal. 31 (1994) 1497."""
    if np.imag(z) < 0:
        return 2 * np.exp(-z * z) - wofz(-z, n)
    m = 2 * n
    length = np.sqrt(n / np.sqrt(2))
    x = length * np.tan(np.arange(-m + 1, m) * np.pi / (2 * m))
    f = np.concatenate(([0], np.exp(-x * x) * (length**2 + x * x)))
    c = np.real(np.fft.fft(np.fft.fftshift(f))) / (2 * m)
    c = np.flipud(c[1 : n + 1])
    t = (length + 1j * z) / (length - 1j * z)
    return 2 * np.polyval(c, t) / (length - 1j * z) ** 2 + 1 / np.sqrt(np.pi) / (length - 1j * z)


rho1 = rho2 = 1.0
sigma, k = 1.0, 2 * np.pi
nu = 3000 ** -0.5
n, b = nu * k**2, rho1 * rho2 / (rho1 + rho2) ** 2
w2 = sigma * k**3 / (rho1 + rho2)
z = np.roots([1, -4 * b * n**0.5, 2 * (1 - 6 * b) * n, 4 * (1 - 3 * b) * n**1.5, (1 - 4 * b) * n**2 + w2])
Z = [np.prod([z[j] - z[i] for j in range(4) if j != i]) for i in range(4)]

def a(t):
    s = np.sqrt(t)
    # exp(z^2 t) erfc(z s) = w(i z s)
    terms = sum(z[i] / Z[i] * w2 / (z[i] ** 2 - n) * np.exp(-n * t) * wofz(1j * z[i] * s) for i in range(4))
    first = 4 * (1 - 4 * b) * n**2 / (8 * (1 - 4 * b) * n**2 + w2) * wofz(1j * np.sqrt(n) * s) * np.exp(-n * t)
    return (terms + first).real

if __name__ == "__main__":
    assert abs(a(0.0) - 1) < 1e-12 and abs((a(1e-8) - a(0.0)) / 1e-8) < 1e-3 * w2**0.5
    print("t,a")
    for t in np.linspace(0, 25 / w2**0.5, 101):
        print(f"{t:.6f},{a(t):.6f}")
