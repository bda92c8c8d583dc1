"""Gauss and Newton's method with a complex unknown at every line and real parameters that all lines share.

ln α is holomorphic in the unknown functions z, so that each line has its own complex normal equations. They
are eliminated line by line, and the parameters p follow from the real Schur complement

    S = A_pp − Re Σ A_zpᴴ A_zz⁻¹ A_zp,

profiled jointly rather than in turn. The prior on p counts as many times as χ² is large: a wrong place must
not be bought by re-tuning the robot.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Complex, Float

from flexmodal.diagnosis.lawfree.at_parameters import AtParameters
from flexmodal.diagnosis.lawfree.beginning import origin
from flexmodal.diagnosis.lawfree.elimination import Damping, stepped
from flexmodal.diagnosis.lawfree.equations import Equations, products
from flexmodal.diagnosis.lawfree.model import PortedModel, Unknown
from flexmodal.errors import SingularResponse
from flexmodal.identification.descent import robust, robust_weight
from flexmodal.identification.frf_fit import Weighting, square

RIDGE = 1e-3
"""Precision of a weak prior on the functions in units of their sizes: lines that say nothing stay small."""
LONGEST = 2.0
"""Longest step of a function at one line, in its size or multiples of what it is."""
FIRST, LAST = 1e-3, 1e4
"""Damping of the first step, and where a descent gives up."""
SETTLED = 5e-4
"""Relative change of the cost by a step that ends a descent."""


@dataclass(frozen=True, eq=False)
class State:
    """Where a descent stands."""

    at: AtParameters
    z: Unknown
    cost: float
    """Robust sum of squares with all priors."""
    residual: Complex[np.ndarray, "observation line"]
    """Not a number where the model does not exist."""

    @property
    def x(self) -> Float[np.ndarray, " parameter"]:
        """Coordinates of the parameters."""
        return self.at.x

    @property
    def light(self) -> State:
        """The same without the solved structures, which are large; they are solved again when asked for."""
        return replace(self, at=AtParameters(self.at.model, self.at.x))


@dataclass(frozen=True, eq=False)
class Profile:
    """A ported model to be fitted at one relative model error."""

    model: PortedModel
    floor: float
    pooled: bool = False
    """Whether a function is one number over all lines, in its size."""
    still: int = 0
    """Functions, the first so many, that stay as they are."""
    settled: float = SETTLED
    """A step that changes the cost relatively by less ends a descent."""

    @cached_property
    def weight(self) -> Float[np.ndarray, "observation line"]:
        """1/(σ² + ε²)."""
        return Weighting(self.floor, self.model.lines).weight(self.model.observations)

    @cached_property
    def origin(self) -> Float[np.ndarray, " parameter"]:
        """Where the priors are centred."""
        return origin(self.model)

    def state(self, x: Float[np.ndarray, " parameter"], z: Unknown) -> State:
        """A state with its cost, infinite where the model does not exist.

        Args:
            x: coordinates of the parameters.
            z: the functions in their sizes.
        """
        return self.with_functions(AtParameters(self.model, x), z)

    def with_functions(self, at: AtParameters, z: Unknown) -> State:
        """A state at parameters where the model was looked at before.

        Args:
            at: the model there.
            z: the functions in their sizes.
        """
        try:
            r = at.residual(z)
        except (np.linalg.LinAlgError, SingularResponse):
            r = np.full((len(self.model.observations), len(self.model.lines)), complex(np.nan))
        return self.judged(State(at, z, np.inf, r))

    def judged(self, state: State) -> State:
        """A state of the same model at this model error."""
        ridge = float(np.sum(self._ridge[:, None] * np.abs(state.z) ** 2))
        misfit = self.misfit(state.residual)
        believed = float(np.sum(self.model.space.precision * (state.x - self.origin) ** 2))
        cost = misfit + max(1.0, 2 * misfit / self._spare) * believed + ridge
        return replace(state, cost=cost if np.isfinite(cost) else np.inf)

    def descended(self, state: State, most: int, *, held: bool = False) -> State:
        """Some steps down.

        Args:
            state: where it starts.
            most: steps.
            held: whether the parameters stay as they are.
        """
        if not np.isfinite(state.cost):
            return state
        lines = 1 if self.pooled else len(self.model.lines)
        damping, own = FIRST, np.full((self.model.cells, lines), FIRST)
        for _ in range(most):
            equations, temper = self.equations(state, held=held), self.temper(state.residual)
            found = None
            while found is None and damping < LAST:
                trial, better = self._tried(state, equations, (damping, own), temper)
                own = np.where(better, own / 5, np.maximum(own, 1e-4) * 10)
                if trial.cost < state.cost:
                    found = trial
                else:
                    damping = max(damping, 1e-4) * 10
            if found is None:
                break
            gained = (state.cost - found.cost) / max(state.cost, 1e-300)
            state, damping = found, damping / 5
            if gained < self.settled:
                break
        return state

    def misfit(self, residual: Complex[np.ndarray, "observation line"]) -> float:
        """Robust χ²; infinite where there is no model."""
        found = float(self._each(residual).sum())
        return found if np.isfinite(found) else np.inf

    def _each(self, residual: np.ndarray) -> Float[np.ndarray, "observation line"]:
        return robust(self.weight * square(residual))

    @cached_property
    def _spare(self) -> float:
        """The number of real values less that of the unknown ones."""
        lines = 1 if self.pooled else len(self.model.lines)
        common = int(np.count_nonzero(self.model.common))
        functions = self.model.cells * (len(self.model.names) - common) + common
        unknown = 2 * functions * lines + len(self.model.space)
        return max(self._values - unknown, 0.05 * self._values, 1.0)

    @cached_property
    def _values(self) -> int:
        """Real values that count."""
        return 2 * int(np.count_nonzero(self.weight))

    def temper(self, residual: Complex[np.ndarray, "observation line"]) -> float:
        """Reduced χ², at least 1."""
        return max(1.0, self.reduced(residual))

    def reduced(self, residual: Complex[np.ndarray, "observation line"]) -> float:
        """Robust χ² over the number of real values less that of the unknown ones."""
        return 2 * self.misfit(residual) / self._spare

    def mean(self, residual: Complex[np.ndarray, "observation line"]) -> float:
        """Robust χ² over the number of real values, where nothing was fitted."""
        return 2 * self.misfit(residual) / max(self._values, 1)

    @cached_property
    def _cells(self) -> list[slice] | list[np.ndarray]:
        """The observations of each cell."""
        if self.model.cells == 1:
            return [slice(None)]
        return [self.model.cell == cell for cell in range(self.model.cells)]

    def by_line(
        self, residual: Complex[np.ndarray, "observation line"], z: Unknown
    ) -> Float[np.ndarray, "cell line"]:
        """Robust sum of squares of each line, with the prior of its functions; of all cells that share any.

        Args:
            residual: there.
            z: the functions in their sizes.
        """
        each = self._each(residual)
        sums = np.array([each[rows].sum(axis=0) for rows in self._cells])
        sums += np.sum(self._ridge[:, None] * np.abs(z) ** 2, axis=1)
        if self.model.common.any():  # a line of a common function is the same line in all cells
            return np.broadcast_to(sums.sum(axis=0), sums.shape)
        return np.asarray(sums)

    @cached_property
    def _ridge(self) -> Float[np.ndarray, " function"]:
        """`RIDGE` of each function in each cell; of one that all cells share its part."""
        return RIDGE / np.where(self.model.common, self.model.cells, 1)

    def equations(self, state: State, *, held: bool = False) -> Equations:
        """Normal equations.

        Args:
            state: where.
            held: whether the parameters stay as they are and have none.
        """
        slopes = state.at.slopes(state.z, held=held)
        root = np.sqrt(self.weight * robust_weight(self.weight * square(state.residual)))
        along, r = slopes.along[..., self.still :] * root[..., None], state.residual * root
        parameters = slopes.parameters * root[:, None]
        flat = parameters.reshape(len(parameters), 2 * r.size)
        pull = np.stack([r.real, r.imag], axis=1).ravel()
        lines = len(self.model.lines) if self.pooled else 1
        own = (state.z.mean(axis=2, keepdims=True) if self.pooled else state.z)[:, self.still :]
        found = [
            products(along[rows], r[rows], parameters[:, rows], pooled=self.pooled) for rows in self._cells
        ]
        zz, zp, z = (np.stack(parts) for parts in zip(*found, strict=True))
        ridge = lines * self._ridge[self.still :]
        return Equations(
            zz + np.diag(ridge),
            zp,
            z + ridge * np.swapaxes(own, 1, 2),
            flat @ flat.T,
            flat @ pull,
        )

    def _tried(
        self, state: State, equations: Equations, damping: Damping, temper: float
    ) -> tuple[State, Bool[np.ndarray, "cell each"]]:
        """A state farther down, if it is, and on which lines the step of the functions serves."""
        prior, (low, high) = temper * self.model.space.precision, self.model.space.bounds
        step, along = self.step(state, equations, damping, prior)
        held = not len(equations.p)
        at = state.at if held else AtParameters(self.model, np.clip(state.x + step, low, high))
        most = LONGEST * np.maximum(1.0, np.abs(state.z))
        z = state.z + along / np.maximum(1.0, np.abs(along) / most)
        trial = self.with_functions(at, z)
        if self.pooled or not np.isfinite(trial.cost):
            return trial, np.full(damping[1].shape, trial.cost < state.cost)
        kept = state if held else self.with_functions(at, state.z)
        better = self.serves(trial, kept)
        return self.chosen(trial, kept, better), better

    def serves(self, one: State, other: State) -> Bool[np.ndarray, "cell line"]:
        """On which lines the functions of a state cost no more than those of another at the same parameters.

        Args:
            one: the state; on all of them where the other has no finite cost.
            other: the other one.
        """
        if not np.isfinite(other.cost):
            return np.full((self.model.cells, len(self.model.lines)), True)
        return np.asarray(self.by_line(one.residual, one.z) <= self.by_line(other.residual, other.z))

    def chosen(self, one: State, other: State, first: Bool[np.ndarray, "cell line"]) -> State:
        """Of two states at the same parameters the functions of either on some lines.

        A line's residuals depend on its own functions alone, so nothing has to be solved again.

        Args:
            one: a state.
            other: another one.
            first: lines on which the first one's functions are taken.
        """
        if first.all():
            return one
        z = np.where(first[:, None], one.z, other.z)
        residual = np.where(first[self.model.cell], one.residual, other.residual)
        return self.judged(State(one.at, z, np.inf, residual))

    def step(
        self, state: State, equations: Equations, damping: Damping, prior: Float[np.ndarray, " parameter"]
    ) -> tuple[Float[np.ndarray, " parameter"], Unknown]:
        """Steps of the parameters and the functions.

        Args:
            state: where it starts.
            equations: there.
            damping: part of the diagonals that is added, of the parameters and of each line's functions.
            prior: precision of the parameters.
        """
        some = slice(len(equations.p))  # none where they are held
        low, high = self.model.space.bounds
        known = np.diag(prior[some]), (prior * (state.x - self.origin))[some]
        bound = (state.x <= low)[some], (state.x >= high)[some]
        step, every = np.zeros(len(state.x)), np.zeros(state.z.shape, dtype=complex)
        step[some], every[:, self.still :] = stepped(
            equations, damping, known, bound, self.model.common[self.still :]
        )
        return step, every
