"""The equations of motion of one run: its constants, and the generators of its phases."""

from dataclasses import dataclass, field, replace

from mpmath import mp, mpf

from high_precision.series import Modal, Taylor

STIFF = 100
TABLE = {"kappa": 2.41, "d1": 0.0033, "d2": 0.0120, "kappa3": 1.80, "d3": 0.0330, "restitution": 0.5}
TOUCHING = {"clearance": 0.0, "wall": False}
BASE_ONLY = {"base": 1.0, "base_phase": 0.0, "force1": 0.0, "force1_phase": 0.0, "force2": 0.0, "force2_phase": 0.0}
BASE_ONLY |= {"constant1": 0.0, "constant2": 0.0}
SIZE = 7  # of y


@dataclass
class Problem:
    """One run: system, excitation, η, method, start.

    With a clearance c the gap is g = c + ξ₂ − ξ₁. The accelerations by the excitation are, for i = 1, 2 and m₁ = 1,
    m₂ = μ,

        aᵢ = base η² cos(ητ + base_phase) + (forceᵢ cos(ητ + forceᵢ_phase) + constantᵢ)/mᵢ.

    Beside a wall body 2 stays at ξ₂ = 0. This is the limit μ → ∞: the gap then has body 1's own equation of motion, and
    ξ₁ = c − g follows from it.

    Attributes
    ----------
    eta : float
    method : dict
        {"name": "reference", "joint_damping": "table" or "derived", "threshold": ε} or
        {"name": "exact", "stiffness": K, "damping": D}.
    periods : int
    system : dict
        What differs from Table 1, from a clearance of zero, or from two bodies ("wall": True). A "mass_ratio" μ may
        take the place of κ₃.
    initial : tuple of 4 float
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0.
    excitation : dict
        What differs from a base that moves as cos ητ without forces on the bodies.
    samples : int
        States per period.
    """

    eta: float
    method: dict
    periods: int
    system: dict = field(default_factory=dict)
    initial: tuple = (0.0, 0.0, 0.0, 0.0)
    stiff: float = STIFF
    excitation: dict = field(default_factory=dict)
    samples: int = 1

    def __post_init__(self):
        numbers = TABLE | TOUCHING | self.system
        self.wall = numbers.pop("wall")
        s = {name: mpf(value) for name, value in numbers.items()}
        self.clearance, self.restitution = s["clearance"], s["restitution"]
        self.c1 = 2 * s["d1"]  # ξᵢ″ + cᵢξᵢ′ + …
        self.omega = mpf(self.eta)  # η with all digits
        self.period = 2 * mp.pi / self.omega
        if self.wall:
            self.mu, self.inverse_mu, self.mass_share = mpf(0), mpf(0), mpf(1)  # body 2 has no energy
            self.kappa = self.kappa3 = self.c2 = self.c3 = mpf(0)
        else:
            self._join(s)
        self.loads1, self.loads2 = self._loads()

    def _join(self, s):
        """Set the constants of body 2 and of the joined bodies."""
        self.kappa, self.c2 = s["kappa"], 2 * s["d2"] * s["kappa"]
        if "mass_ratio" in s:
            self.mu = s["mass_ratio"]
            s["kappa3"] = mp.sqrt((1 + self.mu * s["kappa"] ** 2) / (1 + self.mu))
        else:
            self.mu = (s["kappa3"] ** 2 - 1) / (s["kappa"] ** 2 - s["kappa3"] ** 2)
        self.kappa3 = s["kappa3"]
        self.inverse_mu, self.mass_share = 1 / self.mu, self.mu / (1 + self.mu)
        derived = (s["d1"] + self.mu * s["d2"] * s["kappa"]) / ((1 + self.mu) * s["kappa3"])
        self.c3 = 2 * self.kappa3 * (s["d3"] if self.method.get("joint_damping") == "table" else derived)

    def _loads(self):
        """The accelerations of both bodies by the excitation, as factors of cos ητ, sin ητ and 1."""
        e = {name: mpf(value) for name, value in (BASE_ONLY | self.excitation).items()}

        def parts(amplitude, phase):
            # without a phase exactly zero, so that no entry of A is a rounding error
            return [amplitude * mp.cos(phase), -amplitude * mp.sin(phase) if phase else mpf(0)]

        base = [*parts(e["base"] * self.omega**2, e["base_phase"]), mpf(0)]
        forces = [[*parts(e[f"force{i}"], e[f"force{i}_phase"]), e[f"constant{i}"]] for i in (1, 2)]
        one = [b + f for b, f in zip(base, forces[0], strict=True)]
        return one, [mpf(0)] * 3 if self.wall else [
            b + f * self.inverse_mu for b, f in zip(base, forces[1], strict=True)
        ]

    def again(self, **changed):
        """The same problem, its constants computed anew with the present number of digits."""
        return replace(self, **changed)

    def start(self):
        """The initial y."""
        x1, v1, x2, v2 = map(mpf, self.initial)
        if self.wall:
            return [mpf(0), mpf(0), self.clearance - x1, -v1, mpf(1), mpf(0), mpf(1)]
        return [x1, v1, self.clearance + x2 - x1, v2 - v1, mpf(1), mpf(0), mpf(1)]

    def state(self, y):
        """ξ₁, ξ₁′, ξ₂, ξ₂′ of y."""
        x1, v1, g, u = y[:4]
        if self.wall:
            return self.clearance - g, -u, mpf(0), mpf(0)
        return x1, v1, x1 + g - self.clearance, v1 + u

    def free_acceleration(self):
        """g″ of the motion without contact, as a row; λ of permanent contact is −μ/(1 + μ) times it, at g = g′ = 0."""
        relative = [b - a for a, b in zip(self.loads1, self.loads2, strict=True)]
        if self.wall:
            relative[2] += self.clearance
            return [0, 0, -1, -self.c1, *relative]
        relative[2] += self.kappa**2 * self.clearance
        return [1 - self.kappa**2, self.c1 - self.c2, -(self.kappa**2), -self.c2, *relative]

    def force_row(self):
        """λ of permanent contact, as a row."""
        row = [-self.mass_share * x for x in self.free_acceleration()]
        row[2] = row[3] = 0
        return row

    def matrix(self, stiffness=0, damping=0):
        """A of flight, or of penalty contact with λ = −Kg − 2Dg′."""
        k, d, more = mpf(stiffness), 2 * mpf(damping), 1 + self.inverse_mu
        gap = self.free_acceleration()
        gap[2] -= k * more
        gap[3] -= d * more
        body1 = [[0, 1, 0, 0, 0, 0, 0], [-1, -self.c1, k, d, *self.loads1]]
        return [*self._rows_of_body1(body1), [0, 0, 0, 1, 0, 0, 0], gap, *self._rows_of_time()]

    def joined_matrix(self):
        """A of permanent contact."""
        share = self.mass_share  # of body 2, in the total of both masses
        common = [a + share * (b - a) for a, b in zip(self.loads1, self.loads2, strict=True)]
        common[2] += share * self.kappa**2 * self.clearance
        body1 = [[0, 1, 0, 0, 0, 0, 0], [-(self.kappa3**2), -self.c3, 0, 0, *common]]
        return [*self._rows_of_body1(body1), [0] * SIZE, [0] * SIZE, *self._rows_of_time()]

    def _rows_of_body1(self, rows):
        """The rows of ξ₁ and ξ₁′; beside a wall they stay zero, since the gap says all."""
        return [[0] * SIZE] * 2 if self.wall else rows

    def _rows_of_time(self):
        return [[0, 0, 0, 0, 0, -self.omega, 0], [0, 0, 0, 0, self.omega, 0, 0], [0] * SIZE]

    def phase(self, name):
        """Flight (f = g), permanent contact "joined" (f = λ) or penalty "contact" (f = −g)."""
        size = max([mpf(1), *map(abs, self.loads1 + self.loads2), self.kappa**2 * abs(self.clearance)])
        weights = [mpf(1)] * 4 + [size] * 3  # so that large loads do not shorten the steps
        if name == "joined":
            return Taylor(self.joined_matrix(), self.force_row(), weights)
        if name == "flight":
            return Taylor(self.matrix(), [0, 0, 1, 0, 0, 0, 0], weights)
        matrix = self.matrix(self.method["stiffness"], self.method["damping"])
        row = [0, 0, -1, 0, 0, 0, 0]
        weights[2] = max(mpf(1), mp.sqrt(mpf(self.method["stiffness"]) * (1 + self.inverse_mu)))
        taylor = Taylor(matrix, row, weights)
        return taylor if taylor.norm <= self.stiff else Modal(matrix, row)
