"""The base of a study: parameters that are swept, cells at the points of their grid, and the variables of each cell.

The five studies differ in what they sweep and in what they compute. Batches, stores, resuming and the cluster are the
same for all of them and use no more of a study than stands here.

The values along an axis of a study, checked or evenly spaced, and the start of its runs.
"""

import abc
import hashlib
import itertools
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from vibroscope.engine.arguments import Poll, check_fields, require, shown, whole
from vibroscope.engine.cells import CellResults, Cells, run_cells
from vibroscope.engine.methods import METHOD_NUMBERS, Method
from vibroscope.engine.model import BODY_2, FORCES_ON_BODY_2, System, check_eta
from vibroscope.engine.simulate import KEEP_LIMIT, PERIODS_LIMIT, STEPS_LIMIT
from vibroscope.engine.sweeps.digest import engine_digest
from vibroscope.engine.sweeps.variables import SWEPT, StudyArray, Variable

if TYPE_CHECKING:
    from vibroscope.engine.sweeps.batches import Batch, Chunk


LARGEST_SWEPT = 1e300  # of a range


def ascending_values(name: str, values: Sequence[float]) -> np.ndarray:
    """The values of an axis, checked.

    Raises
    ------
    ValueError
        If there are none, or they do not ascend strictly.
    """
    try:
        array = np.array(values, dtype=float).reshape(-1)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"the values of {name} are not numbers: give at least one") from None
    if not len(array):
        raise ValueError(f"no value of {name}: give at least one")
    if not (np.isfinite(array).all() and (np.diff(array) > 0).all()):
        raise ValueError(f"the values of {name} do not ascend strictly: sort them, and give each once")
    if name == "steps" and (array != np.round(array)).any():
        raise ValueError(f"steps = {array[array != np.round(array)][0]:g} is not a whole number: give steps per period")
    return array


def start_of(initial: Sequence[float] | None) -> tuple[float, ...] | None:
    """ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, or None for rest.

    Raises
    ------
    ValueError
        If they are not four numbers.
    """
    if initial is None:
        return None
    try:
        start = np.asarray(initial, float)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"initial = {shown(initial)} are no numbers: give the four of the state") from None
    if start.shape != (4,):
        raise ValueError(f"initial has {start.size} numbers: give the four of the state, ξ₁, ξ₁′, ξ₂, ξ₂′")
    return tuple(start.tolist())


def spaced(name: str, low: float, high: float, count: float, *, logarithmic: bool = False) -> np.ndarray:
    """Values from low to high, evenly spaced or evenly in the logarithm; ``steps`` are rounded to whole numbers.

    Raises
    ------
    ValueError
        If the range is empty, not positive where it is logarithmic, or the count is no number of values.

    Examples
    --------
    >>> from vibroscope.engine import spaced
    >>> spaced("K", 100, 10000, 3, logarithmic=True).round(6).tolist()
    [100.0, 1000.0, 10000.0]
    """
    n = whole(f"count of {name}", count, 1, 10_000_000, "give the number of values")  # held in memory
    low, high = (
        require(name, end, -LARGEST_SWEPT, LARGEST_SWEPT, "give the ends of the range as numbers")
        for end in (low, high)
    )
    if not (low < high or (low == high and n == 1)):
        raise ValueError(f"{name} from {low:g} to {high:g} is an empty range: give the smaller number first")
    if logarithmic:
        require(name, low, 0, LARGEST_SWEPT, "a logarithmic axis begins above 0", open_low=True)
    values = (np.geomspace if logarithmic else np.linspace)(low, high, n)
    return np.unique(np.round(values)) if name == "steps" else values


CELLS_LIMIT = 1_000_000_000
NUMBERS_LIMIT = 10**12  # numbers in a result: 8 TB

SYSTEM_PARAMETERS = tuple(name for name in SWEPT if name not in ("eta", *METHOD_NUMBERS))


@dataclass(frozen=True, eq=False)
class Study(abc.ABC):
    """Base of the five studies.

    Attributes
    ----------
    system : System
    method : Method
        Holds for all cells but for the numbers that are swept.
    eta : float, optional
        Excitation frequency η = Ω/ω₁ where it is not swept itself.
    transient, sample : int
        Periods that each cell runs before the sample, and those that are described.

    Raises
    ------
    ValueError
        If a number is out of range; :meth:`check` looks at all of them together.
    """

    system: System
    method: Method
    eta: float | None = None
    transient: int = field(default=2000, kw_only=True)
    sample: int = field(default=50, kw_only=True)
    kind: ClassVar[str]
    effort: ClassVar[int] = 1  # how many times as long a period takes, so that chunks hold fewer cells
    grid: ClassVar[tuple[str, ...]]  # attributes that hold the swept values, slowest first
    sequential: ClassVar[bool] = False  # whether a batch starts from the end of the one before
    backwards: ClassVar[bool] = False  # whether the last batch comes first

    def __post_init__(self):
        check_fields(self)
        transient = whole("transient", self.transient, 0, PERIODS_LIMIT, "give the periods before the sample")
        sample = whole("sample", self.sample, 1, KEEP_LIMIT, "give the periods to describe")
        values = {
            held: ascending_values(name, getattr(self, held))
            for name, held in zip(self.axis_names, self.grid, strict=True)
        }
        self._set(transient=transient, sample=sample, **values)

    def _set(self, **checked) -> None:
        """Replace attributes by their checked values."""
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @property
    def axis_names(self) -> tuple[str, ...]:
        """The parameters that are swept; those that hold their values have the same names, unless said otherwise."""
        return self.grid

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """The swept parameters, slowest first; a cell is a point of their grid."""
        return {name: getattr(self, held) for name, held in zip(self.axis_names, self.grid, strict=True)}

    @property
    @abc.abstractmethod
    def variables(self) -> dict[str, Variable]:
        """The variables of each cell; the dimensions begin with those of `axes`. ``status`` comes last."""

    @cached_property
    def arrays(self) -> dict[str, StudyArray]:
        """The arrays that are known before any cell is computed, the axes first."""
        return {name: StudyArray((name,), values, SWEPT[name]) for name, values in self.axes.items()}

    @property
    def inner_lengths(self) -> dict[str, int]:
        """Length of every dimension but those of `axes`."""
        return {"sample": self.sample, "component": 4}

    @property
    def options(self) -> dict[str, object]:
        """Further numbers that the result depends on."""
        return {}

    def conclusions(self, values: Mapping[str, np.ndarray]) -> dict[str, StudyArray]:
        """The results that follow from the variables of all cells that are known."""
        return {}

    def cut(self, chunk: "Chunk") -> "Study":
        """The study of the cells of a chunk."""
        return replace(self, **{held: getattr(self, held)[part] for held, part in zip(self.grid, chunk, strict=True)})

    @abc.abstractmethod
    def compute(
        self,
        batch: "Batch | None" = None,
        *,
        before: dict[str, np.ndarray] | None = None,
        threads: int | None = None,
        progress: Callable[[int], None] | None = None,
        cancelled: Poll | None = None,
    ) -> dict[str, np.ndarray]:
        """The variables of a batch of cells (by default all), in the shape that a grid has at this index.

        The cells of a batch ascend along each axis. ``before`` are the variables of the batch before, if `sequential`.
        """

    @property
    def shape(self) -> tuple[int, ...]:
        """Cells along each axis."""
        return tuple(len(values) for values in self.axes.values())

    @property
    def cells(self) -> int:
        """How many cells there are."""
        return math.prod(self.shape)

    @property
    def periods_per_cell(self) -> int:
        """Periods to run for a cell: the size of chunks follows from it."""
        return self.effort * (self.transient + self.sample)

    @property
    def lengths(self) -> dict[str, int]:
        """Length of every dimension."""
        return dict(zip(self.axes, self.shape, strict=True)) | self.inner_lengths

    @property
    def numbers_per_cell(self) -> int:
        """Numbers that a cell leaves in the result."""
        lengths = self.lengths
        inner = [variable.dims[len(self.axes) :] for variable in self.variables.values()]
        return sum(math.prod(lengths[dim] for dim in dims) for dims in inner)

    def check(self) -> None:
        """Look for everything that cannot work before work starts.

        Raises
        ------
        ValueError
            Naming the number, the range and what to do.
        """
        check_eta(self.eta)
        require("cells", float(np.prod(self.shape, dtype=float)), 1, CELLS_LIMIT, "sweep fewer values")
        require("numbers in the result", self.cells * self.numbers_per_cell, 1, NUMBERS_LIMIT, "keep a smaller sample")
        self._check_corners()

    def _idle_parameters(self) -> tuple[str, ...]:
        """Parameters that the system does not have, or that follow from others."""
        return (*BODY_2, *FORCES_ON_BODY_2) if self.system.wall else () if self.system.mu is None else ("kappa3",)

    def _check_corners(self) -> None:
        idle = [name for name in self.axes if name in self._idle_parameters()]
        if idle:
            why = "a wall has no such number" if self.system.wall else "it follows from the mass ratio, which is given"
            raise ValueError(f"{idle[0]} cannot be swept: {why}; sweep another parameter")
        # each parameter is allowed within an interval, so that the ends of the axes stand for all cells
        ends = ([float(values[0]), float(values[-1])] for values in self.axes.values())
        for corner in itertools.product(*ends):
            point = dict(zip(self.axes, corner, strict=True))
            constants = {name: value for name, value in point.items() if name in SYSTEM_PARAMETERS}
            own = {METHOD_NUMBERS[name]: value for name, value in point.items() if name in METHOD_NUMBERS}
            method = replace(self.method, **own)
            check_eta(point.get("eta", self.eta))
            self.system.changed(constants)  # raises where constants do not go together
            steps = method.steps * self.periods_per_cell
            require("periods × steps", steps, 0, STEPS_LIMIT, "run fewer periods or fewer steps per period")

    def points(self, batch: "Batch | None" = None) -> dict[str, np.ndarray]:
        """The swept parameters of the cells of a batch (by default all), each in the shape of the batch."""
        index = batch or (slice(None),) * len(self.axes)
        columns = [values[part] for values, part in zip(self.axes.values(), index, strict=True)]
        if isinstance(index[0], slice):
            columns = np.meshgrid(*columns, indexing="ij")
        return dict(zip(self.axes, columns, strict=True))

    def cells_at(self, points: dict[str, np.ndarray], **more) -> Cells:
        """Cells at values of the swept parameters, in one row; all other numbers are those of the study."""
        points = {name: values.ravel() for name, values in points.items()}
        n = len(next(iter(points.values())))
        constants = {name: values for name, values in points.items() if name in SYSTEM_PARAMETERS}
        system = self.system
        if constants:
            system = [system.changed({name: float(values[i]) for name, values in constants.items()}) for i in range(n)]
        own = {METHOD_NUMBERS[name]: values for name, values in points.items() if name in METHOD_NUMBERS}
        return Cells(system, points.get("eta", np.full(n, self.eta)), self.method, **own, **more)

    def starts_of(self, chosen: np.ndarray, ends: np.ndarray) -> np.ndarray | None:
        """Where runs that judge some cells begin, (m, 4): None for rest; in a chain, where they ended."""
        return ends[chosen] if self.sequential else None

    def run(self, cells: Cells, **how) -> CellResults:
        """Run cells for the periods of the study; keywords as of :func:`engine.run_cells`."""
        return run_cells(cells, transient=self.transient, sample=self.sample, **how)

    def in_shape(self, values: Mapping[str, np.ndarray], points: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The variables of cells that stand in one row, in the shape of their points."""
        shape = next(iter(points.values())).shape
        return {name: values[name].reshape(shape + values[name].shape[1:]) for name in self.variables}

    def numbers(self) -> dict[str, object]:
        """Every number that the result depends on, the digest of the engine's code included."""
        swept = {METHOD_NUMBERS.get(name, name) for name in self.axes}
        fixed = {} if "eta" in swept else {"eta": self.eta}
        return fixed | {
            "study": self.kind,
            "system": {name: value for name, value in self.system.as_dict().items() if name not in swept},
            "method": {name: value for name, value in _method_numbers(self.method).items() if name not in swept},
            "transient": self.transient,
            "sample": self.sample,
            "axes": {
                name: [len(values), float(values[0]), float(values[-1]), hashlib.sha256(values.tobytes()).hexdigest()]
                for name, values in self.axes.items()
            },
            "options": self.options,
            "variables": {name: variable.dtype for name, variable in self.variables.items()},
            "engine": engine_digest(),
        }

    @cached_property
    def key(self) -> str:
        """Name of the result: changes with any number that goes in and with any code that computes it."""
        return hashlib.sha256(json.dumps(self.numbers(), sort_keys=True).encode()).hexdigest()[:20]


def _method_numbers(method: Method) -> dict[str, object]:
    numbers = {"name": method.name} | asdict(method)
    if method.has_step:  # its class names the integrator, not its numbers
        numbers["integrator"] = {"name": method.integrator.name} | numbers["integrator"]
    return numbers
