"""What a study is: parameters that are swept, cells at their grid points, and the variables that each cell tells.

The three studies differ in what they sweep and in what they compute; cutting into chunks, keeping, resuming and
spreading over machines is the same for all and knows no more of a study than stands here.
"""

import abc
import hashlib
import itertools
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..cells import Cells
from ..methods import Method
from ..model import System, check_eta, require, whole
from ..simulate import KEEP_LIMIT, PERIODS_LIMIT, STEPS_LIMIT
from .chunks import Chunk
from .provenance import engine_digest
from .variables import Variable, Whole

if TYPE_CHECKING:
    import xarray

CELLS_LIMIT = 1_000_000_000
NUMBERS_LIMIT = 10**12  # numbers in a result: 8 TB

# Parameters that can be swept: how they are named in the result → in `Cells` or in `System`.
OF_CELLS = {"K": "stiffness", "D": "damping", "steps": "steps"}
OF_SYSTEM = ("kappa", "kappa3", "d1", "d2", "d3", "restitution")
MEANING = {
    "eta": "excitation frequency Ω/ω₁",
    "K": "contact stiffness",
    "D": "contact damping",
    "steps": "steps per excitation period",
    "kappa": "frequency ratio of pendulum 2",
    "kappa3": "frequency ratio of the joined pendulums",
    "d1": "damping ratio of pendulum 1",
    "d2": "damping ratio of pendulum 2",
    "d3": "damping ratio of the joined pendulums",
    "restitution": "coefficient of restitution",
}


@dataclass(frozen=True, eq=False)
class Study(abc.ABC):
    """Base of the three studies.

    Attributes
    ----------
    system : System
    method : Method
        Holds for all cells but for the numbers that are swept.
    eta : float
        Excitation frequency where it is not swept itself.
    transient, sample : int
        Periods that each cell runs before the sample, and those that are described.

    Raises
    ------
    ValueError
        If a number is none that can be; whether all of them together are, :meth:`check` tells.
    """

    system: System
    method: Method
    eta: float
    transient: int
    sample: int
    kind: ClassVar[str]
    sequential: ClassVar[bool] = False  # whether a chunk needs what came out of the one before
    backwards: ClassVar[bool] = False  # whether the last chunk comes first

    def __post_init__(self):
        transient = whole("transient", self.transient, 0, PERIODS_LIMIT, "give the periods before the sample")
        sample = whole("sample", self.sample, 1, KEEP_LIMIT, "give the periods to describe")
        self._take(transient=transient, sample=sample)

    def _take(self, **checked) -> None:
        """Set attributes to what was made of them when the study was checked."""
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @property
    @abc.abstractmethod
    def axes(self) -> dict[str, np.ndarray]:
        """The swept parameters, slowest first; a cell is a point of their grid."""

    @property
    @abc.abstractmethod
    def variables(self) -> dict[str, Variable]:
        """What the chunks hold; the dimensions begin with those of `axes`. ``status`` is among them."""

    @cached_property
    def whole(self) -> dict[str, Whole]:
        """What is known beforehand, the axes first."""
        return {name: Whole((name,), values, MEANING[name]) for name, values in self.axes.items()}

    @property
    def options(self) -> dict[str, object]:
        """Further numbers that the result depends on."""
        return {}

    def conclusions(self, found: "xarray.Dataset") -> dict[str, Whole]:
        """What follows from all cells together."""
        return {}

    @abc.abstractmethod
    def cut(self, chunk: Chunk) -> "Study":
        """The same study of the cells of a chunk."""

    @abc.abstractmethod
    def compute(
        self,
        *,
        before: dict[str, np.ndarray] | None = None,
        threads: int | None = None,
        progress: Callable[[int], None] | None = None,
        cancelled: Callable[[], bool] | None = None,
    ) -> dict[str, np.ndarray]:
        """The variables of all cells; ``before`` are those of the chunk before, if `sequential`."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Cells along each axis."""
        return tuple(len(values) for values in self.axes.values())

    @property
    def cells(self) -> int:
        """How many cells there are."""
        return int(np.prod(self.shape))

    @property
    def periods_per_cell(self) -> int:
        """Periods to run for a cell: what chunks are cut by."""
        return self.transient + self.sample

    @property
    def lengths(self) -> dict[str, int]:
        """Length of every dimension."""
        known = {name: len(values) for name, values in self.axes.items()}
        for item in self.whole.values():
            known |= dict(zip(item.dims, np.shape(item.values), strict=True))
        return known

    @property
    def numbers_per_cell(self) -> int:
        """Numbers that a cell leaves in the result."""
        lengths = self.lengths
        inner = [variable.dims[len(self.axes) :] for variable in self.variables.values()]
        return sum(int(np.prod([lengths[dim] for dim in dims])) for dims in inner)

    def check(self) -> None:
        """Look for everything that cannot work before work starts.

        Raises
        ------
        ValueError
            Naming the number, the range and what to do.
        """
        check_eta(self.eta, self.system)
        require("cells", float(np.prod(self.shape, dtype=float)), 1, CELLS_LIMIT, "sweep fewer values")
        require("numbers in the result", self.cells * self.numbers_per_cell, 1, NUMBERS_LIMIT, "keep a smaller sample")
        self._check_corners()

    def _check_corners(self) -> None:
        # what is allowed is an interval in each parameter, so that the ends of the axes stand for all cells
        ends = ([float(values[0]), float(values[-1])] for values in self.axes.values())
        for corner in itertools.product(*ends):
            point = dict(zip(self.axes, corner, strict=True))
            system = replace(self.system, **{name: point[name] for name in point if name in OF_SYSTEM})
            method = replace(self.method, **{OF_CELLS[name]: point[name] for name in point if name in OF_CELLS})
            check_eta(point.get("eta", self.eta), system)
            steps = getattr(method, "steps", 0) * self.periods_per_cell
            require("periods × steps", steps, 0, STEPS_LIMIT, "run fewer periods or fewer steps per period")

    def cells_at(self, values: dict[str, np.ndarray], **more) -> Cells:
        """Cells with the swept parameters at ``values``, each (n,); all others as in the study."""
        n = len(next(iter(values.values())))
        constants = {name: column for name, column in values.items() if name in OF_SYSTEM}
        system = self.system
        if constants:
            system = [
                replace(system, **{name: float(column[i]) for name, column in constants.items()}) for i in range(n)
            ]
        own = {OF_CELLS[name]: column for name, column in values.items() if name in OF_CELLS}
        return Cells(system, values.get("eta", np.full(n, self.eta)), self.method, **own, **more)

    def points(self) -> dict[str, np.ndarray]:
        """The swept parameters of all cells, each (n,), last axis fastest."""
        grids = np.meshgrid(*self.axes.values(), indexing="ij")
        return {name: grid.ravel() for name, grid in zip(self.axes, grids, strict=True)}

    def numbers(self) -> dict[str, object]:
        """Every number that the result depends on, the engine's sources included."""
        swept = {OF_CELLS.get(name, name) for name in self.axes}
        fixed = {} if "eta" in swept else {"eta": self.eta}
        return fixed | {
            "study": self.kind,
            "system": {name: value for name, value in self.system.as_dict().items() if name not in swept},
            "method": {name: value for name, value in _described(self.method).items() if name not in swept},
            "transient": self.transient,
            "sample": self.sample,
            "axes": {
                name: [len(values), float(values[0]), float(values[-1]), hashlib.sha256(values.tobytes()).hexdigest()]
                for name, values in self.axes.items()
            },
            "options": self.options,
            "engine": engine_digest(),
        }

    @cached_property
    def key(self) -> str:
        """Name of the result: changes with any number that goes in and with any line of the engine."""
        return hashlib.sha256(json.dumps(self.numbers(), sort_keys=True).encode()).hexdigest()[:20]


def _described(method: Method) -> dict[str, object]:
    return {"name": method.name} | asdict(method)
