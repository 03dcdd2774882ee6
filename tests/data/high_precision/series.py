"""One phase of the motion as a power series in time, with a bound of its remainder."""

import mpmath
from mpmath import mp, mpf

REACH = 6


def terms_needed() -> int:
    """N with REACHᴺ/N! below the working precision."""
    n, size = 0, mpf(1)
    while n < REACH or size > mpf(10) ** (-mp.dps - 3):
        n += 1
        size *= mpf(REACH) / n
    return n


def horner(coefficients, s):
    """Value of Σ cⱼ sʲ."""
    value = mpf(0)
    for c in reversed(coefficients):
        value = value * s + c
    return value


class Taylor:
    """One phase in the coordinates of y: A and the row of f, with weights w of the norm max |wᵢ yᵢ|."""

    def __init__(self, matrix, row, weights):
        self.rows = [[(k, mpf(x)) for k, x in enumerate(line) if x != 0] for line in matrix]
        self.row = [(k, mpf(x)) for k, x in enumerate(row) if x != 0]
        self.weights = weights
        self.norm = max(sum(abs(x) * weights[i] / weights[k] for k, x in line) for i, line in enumerate(self.rows))
        self.count = terms_needed()

    def longest(self, y):
        """Longest step from y on."""
        return REACH / self.norm

    def expand(self, y, h):
        """(coefficients of f in s = t/h, bound of their remainder on 0 ≤ s ≤ 1, y as a function of s)."""
        term = list(y)
        terms = [term]
        for j in range(1, self.count + 1):
            scale = h / j
            term = [sum((x * term[k] for k, x in line), mpf(0)) * scale for line in self.rows]
            terms.append(term)
        f = [sum((x * term[k] for k, x in self.row), mpf(0)) for term in terms[:-1]]
        last = max(w * abs(x) for w, x in zip(self.weights, terms[-1], strict=True))
        ratio = self.norm * h / (self.count + 1)
        remainder = sum(abs(x) / self.weights[k] for k, x in self.row) * last / (1 - ratio)
        return f, remainder, lambda s: [horner([term[i] for term in terms], s) for i in range(len(y))]


class Modal:
    """The same for a stiff contact by its modes: y = Re Σ aᵢ rᵢ, aᵢ′ = λᵢaᵢ, one of each conjugate pair."""

    def __init__(self, matrix, row):
        size = len(row)
        with mp.workdps(3 * mp.dps):  # nearly equal eigenvalues (ζ ≈ 1) cost digits
            values, right = mp.eig(mp.matrix(matrix))
            left = right**-1
            tiny = mpf(10) ** -mp.dps * max(map(abs, values)) * mpf(10) ** 10
            self.modes = []
            for i, value in enumerate(values):
                real = abs(value.imag) < tiny
                if real or value.imag > 0:
                    column = [right[k, i] * (1 if real else 2) for k in range(size)]
                    value = mpmath.mpc(value.real, 0 if real else value.imag)
                    self.modes.append((value, column, [left[i, k] for k in range(size)], self._dot(row, column)))
        self.count = terms_needed()
        self.negligible = mpf(10) ** (15 - mp.dps)  # amplitudes below it are rounding errors
        self._powers = {}

    @staticmethod
    def _dot(row, column):
        return sum((x * z for x, z in zip(row, column, strict=True) if x != 0), mpmath.mpc(0))

    def _active_modes(self, y):
        """[(mode, its part of f at the start)] of the modes above rounding, and a bound of the others."""
        parts = [(i, f * self._dot(y, left)) for i, (_, _, left, f) in enumerate(self.modes)]
        omitted = sum((abs(part) for _, part in parts if abs(part) <= self.negligible), mpf(0))
        return [(i, part) for i, part in parts if abs(part) > self.negligible], omitted

    def longest(self, y):
        active, _ = self._active_modes(y)
        fastest = max((abs(self.modes[i][0]) for i, _ in active), default=mpf(0))
        return REACH / (fastest or 1)  # all that moves may have died away

    def expand(self, y, h):
        active, omitted = self._active_modes(y)
        f = [mpf(0)] * self.count
        for i, part in active:
            u, v = part.real, part.imag
            f = [total + u * re - v * im for total, (re, im) in zip(f, self._table(i, h), strict=True)]
        remainder = omitted + sum(abs(part) for _, part in active) * mpf(10) ** -mp.dps
        amplitudes = [self._dot(y, left) for _, _, left, _ in self.modes]

        def at(s):
            evolved = [a * mp.exp(mode[0] * h * s) for a, mode in zip(amplitudes, self.modes, strict=True)]
            return [
                sum((b * mode[1][k] for b, mode in zip(evolved, self.modes, strict=True)), mpmath.mpc(0)).real
                for k in range(len(y))
            ]

        return f, remainder, at

    def _table(self, i, h):
        """(λh)ʲ/j! as pairs."""
        if (i, h) not in self._powers:
            z, line = mpmath.mpc(1), []
            for j in range(self.count):
                line.append((z.real, z.imag))
                z *= self.modes[i][0] * h / (j + 1)
            if len(self._powers) > 64:
                self._powers.clear()
            self._powers[i, h] = line
        return self._powers[i, h]
