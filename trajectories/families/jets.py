"""Jets: Taylor series at each instant, from which derivatives follow without being written out by hand.

A jet holds the coefficients :math:`f^{(k)}(t) / k!`, shape (order + 1, ..., t). The recurrences are those of
Griewank and Walther, Evaluating Derivatives, chapter 13.
"""

from math import factorial

import numpy as np


def product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Jet of a product."""
    out = np.zeros(np.broadcast_shapes(left.shape, right.shape))
    for k in range(len(out)):
        out[k] = sum(left[i] * right[k - i] for i in range(k + 1))
    return out


def power(base: np.ndarray, exponent: float) -> np.ndarray:
    """Jet of a power with a real exponent; the base must not be zero."""
    out = np.empty_like(base)
    out[0] = base[0] ** exponent
    for k in range(1, len(out)):
        out[k] = sum((exponent * i - (k - i)) * base[i] * out[k - i] for i in range(1, k + 1))
        out[k] /= k * base[0]
    return out


def exponential(exponent: np.ndarray) -> np.ndarray:
    """Jet of e to a power."""
    out = np.empty_like(exponent)
    out[0] = np.exp(exponent[0])
    for k in range(1, len(out)):
        out[k] = sum(i * exponent[i] * out[k - i] for i in range(1, k + 1)) / k
    return out


def sine(angle: np.ndarray) -> np.ndarray:
    """Jet of the sine of an angle."""
    rising, falling = np.empty_like(angle), np.empty_like(angle)
    rising[0], falling[0] = np.sin(angle[0]), np.cos(angle[0])
    for k in range(1, len(angle)):
        rising[k] = sum(i * angle[i] * falling[k - i] for i in range(1, k + 1)) / k
        falling[k] = -sum(i * angle[i] * rising[k - i] for i in range(1, k + 1)) / k
    return rising


def derivatives(jet: np.ndarray) -> np.ndarray:
    """Derivatives from the coefficients of a jet, in the same shape."""
    return jet * np.array([factorial(k) for k in range(len(jet))]).reshape(-1, *([1] * (jet.ndim - 1)))
