"""The equations of motion of one run: its constants, and the generators of its phases."""

from dataclasses import dataclass, field

from mpmath import mp, mpf

from .series import Modal, Taylor

STIFF = 100
TABLE = {"kappa": 2.41, "d1": 0.0033, "d2": 0.0120, "kappa3": 1.80, "d3": 0.0330, "restitution": 0.5}


@dataclass
class Problem:
    """One run: system, η, method, start.

    Attributes
    ----------
    eta : float
    method : dict
        {"name": "reference", "joint_damping": "table" or "derived", "threshold": ε} or
        {"name": "exact", "stiffness": K, "damping": D}.
    periods : int
    system : dict
        What differs from Table 1.
    initial : tuple of 4 float
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0.
    """

    eta: float
    method: dict
    periods: int
    system: dict = field(default_factory=dict)
    initial: tuple = (0.0, 0.0, 0.0, 0.0)
    stiff: float = STIFF

    def __post_init__(self):
        s = {name: mpf(value) for name, value in (TABLE | self.system).items()}
        self.kappa, self.restitution = s["kappa"], s["restitution"]
        self.mu = (s["kappa3"] ** 2 - 1) / (s["kappa"] ** 2 - s["kappa3"] ** 2)
        self.mass_share = self.mu / (1 + self.mu)
        self.c1, self.c2 = 2 * s["d1"], 2 * s["d2"] * s["kappa"]  # ξᵢ″ + cᵢξᵢ′ + …
        self.kappa3 = s["kappa3"]
        derived = (s["d1"] + self.mu * s["d2"] * s["kappa"]) / ((1 + self.mu) * s["kappa3"])
        self.c3 = 2 * self.kappa3 * (s["d3"] if self.method.get("joint_damping") == "table" else derived)
        self.omega = mpf(self.eta)  # η with all digits
        self.period = 2 * mp.pi / self.omega

    def start(self):
        """The initial y."""
        x1, v1, x2, v2 = map(mpf, self.initial)
        return [x1, v1, x2 - x1, v2 - v1, self.omega**2, mpf(0)]

    def free_acceleration(self):
        """g″ of the motion without contact, as a row; λ of permanent contact is −μ/(1 + μ) times it, at g = g′ = 0."""
        return [1 - self.kappa**2, self.c1 - self.c2, -(self.kappa**2), -self.c2, 0, 0]

    def matrix(self, stiffness=0, damping=0):
        """A of flight, or of penalty contact with λ = −Kg − 2Dg′."""
        k, d, more = mpf(stiffness), 2 * mpf(damping), 1 + 1 / self.mu
        gap = self.free_acceleration()
        gap[2] -= k * more
        gap[3] -= d * more
        return [
            [0, 1, 0, 0, 0, 0],
            [-1, -self.c1, k, d, 1, 0],
            [0, 0, 0, 1, 0, 0],
            gap,
            [0, 0, 0, 0, 0, -self.omega],
            [0, 0, 0, 0, self.omega, 0],
        ]

    def joined_matrix(self):
        """A of permanent contact."""
        zero = [0] * 6
        return [
            [0, 1, 0, 0, 0, 0],
            [-(self.kappa3**2), -self.c3, 0, 0, 1, 0],
            zero,
            zero,
            [0, 0, 0, 0, 0, -self.omega],
            [0, 0, 0, 0, self.omega, 0],
        ]

    def phase(self, name):
        """Flight (f = g), permanent contact "joined" (f = λ) or penalty "contact" (f = −g)."""
        if name == "joined":
            row = [-self.mass_share * x for x in self.free_acceleration()]
            return Taylor(self.joined_matrix(), row[:2] + [0] * 4, [mpf(1)] * 6)
        if name == "flight":
            return Taylor(self.matrix(), [0, 0, 1, 0, 0, 0], [mpf(1)] * 6)
        matrix = self.matrix(self.method["stiffness"], self.method["damping"])
        row = [0, 0, -1, 0, 0, 0]
        frequency = max(mpf(1), mp.sqrt(mpf(self.method["stiffness"]) * (1 + 1 / self.mu)))
        taylor = Taylor(matrix, row, [mpf(1), mpf(1), frequency, mpf(1), mpf(1), mpf(1)])
        return taylor if taylor.norm <= self.stiff else Modal(matrix, row)
