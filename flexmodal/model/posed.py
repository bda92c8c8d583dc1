"""A robot in a posture: evidence that the posture was applied and the mass matrix is sound."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidPoint, InvalidSystem, InvalidUrdf
from flexmodal.frf import POWER, Frf, PointDirection, frequency_axis, receptance
from flexmodal.frf.axis import check_values
from flexmodal.frf.form import check_form
from flexmodal.modal import (
    LinearModel,
    Modes,
    SecondOrderSystem,
    linear_model,
    model_of_modes,
    solve_modes,
)
from flexmodal.model.build import pinocchio
from flexmodal.model.chain import FlexibleChain
from flexmodal.model.posture import Posture
from flexmodal.text.shown import Shown

_STILL = 1e-12
"""Motion for a unit motion of any joint that is rounding, beside a metre or what other directions have."""

Directions = str | PointDirection | Sequence[str | PointDirection] | None


@dataclass(frozen=True, eq=False, repr=False)
class PosedRobot(Shown):
    """Mass matrix, Jacobians and everything that follows from them, at one posture."""

    robot: FlexibleChain
    posture: Posture
    _data: Any = field(init=False, repr=False)
    _mass: np.ndarray = field(init=False, repr=False)
    _PICTURE: ClassVar[str] = "flexmodal.optimisation.pictures.plot:draw_posed"

    def __post_init__(self) -> None:
        pin = pinocchio()
        model = self.robot.pinocchio
        data = model.createData()
        velocity = np.array([self.posture.values.get(name, 0.0) for name in self.robot.moving])
        configuration = pin.integrate(model, pin.neutral(model), velocity)
        mass = pin.crba(model, data, configuration).copy()
        pin.computeJointJacobians(model, data, configuration)
        pin.updateFramePlacements(model, data)
        object.__setattr__(self, "_data", (data, configuration))
        object.__setattr__(self, "_mass", mass)

    def _facts(self) -> Mapping[str, object]:
        at = " ".join(f"{value:.4g}" for value in self.position(self.robot.tool))
        return {"": self.robot.name, "at": self.posture, f"{self.robot.tool} at [m]": at}

    @cached_property
    def system(self) -> SecondOrderSystem:
        """D, B and K over the flexible joints [kg·m², N·m·s/rad, N·m/rad].

        Raises:
            InvalidUrdf: D is not positive definite; names the link at fault.
        """
        pick = self.robot.flexible_index
        names = tuple(self.robot.joints)
        try:
            mass, robot = self._mass[np.ix_(pick, pick)], self.robot
            return SecondOrderSystem(mass, robot.damping, robot.stiffness, names, robot.hysteresis)
        except InvalidSystem as error:
            raise self._blame(error) from None

    def _blame(self, error: InvalidSystem) -> InvalidUrdf:
        faults = []
        for fault in error.faults:
            joint = fault.key.removeprefix("mass of ")
            link = self.robot.moving[joint].child if joint in self.robot.moving else ""
            key = f"link {link} (moved by joint {joint})" if link else fault.key
            found = f"inertia that leaves the mass matrix not positive definite, {fault.found}"
            faults.append(
                Fault(str(self.robot.urdf.path), key, found, "mass or moment of inertia about every joint")
            )
        return InvalidUrdf(faults)

    def position(self, point: str) -> Float[np.ndarray, "3"]:
        """World position of a point [m].

        Raises:
            InvalidPoint: no such point.
        """
        return self._data[0].oMf[self.robot.frame_of(point)].translation.copy()

    def rotation(self, point: str) -> Float[np.ndarray, "3 3"]:
        """Orientation of a point's frame: its axes in world coordinates, column by column.

        Raises:
            InvalidPoint: no such point.
        """
        return self._data[0].oMf[self.robot.frame_of(point)].rotation.copy()

    def full_jacobian(self, point: str) -> Float[np.ndarray, "6 moving"]:
        """Jacobian of a point over every moving joint, rows x, y, z, rx, ry, rz in the world frame."""
        pin = pinocchio()
        frame = self.robot.frame_of(point)
        world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        jacobian = pin.getFrameJacobian(self.robot.pinocchio, self._data[0], frame, world)
        return jacobian.reshape(6, -1).copy()  # Pinocchio returns a single column as a flat array

    def jacobian(self, point: str) -> Float[np.ndarray, "6 joint"]:
        """Jacobian of a point over the flexible joints, rows x, y, z, rx, ry, rz in the world frame."""
        return self.full_jacobian(point)[:, self.robot.flexible_index]

    def rows(self, directions: Sequence[PointDirection]) -> Float[np.ndarray, "direction joint"]:
        """Jacobian rows of points and directions over the flexible joints.

        Raises:
            InvalidPoint: no such point.
        """
        return np.array([d.selector @ self.jacobian(d.point) for d in directions])

    def motionless(self, directions: Sequence[PointDirection]) -> tuple[PointDirection, ...]:
        """Those of some directions in which no flexible joint moves the point: receptance is 0 there.

        As out of the plane of a planar arm, or along a stretched one.

        Raises:
            InvalidPoint: no such point.
        """
        found = []
        for one in directions:
            jacobian = self.jacobian(one.point)
            part = jacobian[3:] if one.is_rotation else jacobian[:3]
            scale = max(float(np.max(np.abs(part), initial=0.0)), 1.0)
            if np.max(np.abs(one.selector @ jacobian), initial=0.0) <= _STILL * scale:
                found.append(one)
        return tuple(found)

    def mass_derivative(self) -> Float[np.ndarray, "joint joint moving"]:
        """∂D/∂q_k of the mass matrix over the flexible joints, k last and along every moving joint.

        Column by column: without gravity and at rest, the inverse dynamics of a unit acceleration is a
        column of D, and Pinocchio has its derivative.
        """
        pin = pinocchio()
        _, configuration = self._data
        model = self.robot.pinocchio
        scratch = model.createData()
        pick = self.robot.flexible_index
        zero, unit = np.zeros(model.nv), np.eye(model.nv)
        columns = [
            pin.computeRNEADerivatives(model, scratch, configuration, zero, unit[joint])[0][pick]
            for joint in pick
        ]
        return np.stack(columns, axis=1)

    def directions(self, given: Directions) -> tuple[PointDirection, ...]:
        """Read directions; none given means the tool along z.

        Raises:
            InvalidPoint: bad text, no such point, or none at all.
        """
        if given is None:
            given = [PointDirection(self.robot.tool, "z")]
        elif isinstance(given, str | PointDirection):
            given = [given]
        read = tuple(PointDirection.parse(item) for item in given)
        if not read:
            raise InvalidPoint(Fault("call", "directions", "none", "at least one, such as tool:+z"))
        for item in read:
            self.robot.frame_of(item.point)
        return read

    def frf(
        self,
        frequencies: Sequence[float] | np.ndarray,
        *,
        response: Directions = None,
        reference: Directions = None,
        form: str = "receptance",
    ) -> Frf:
        """FRFs between any points and directions.

        Args:
            frequencies: ascending [Hz]; 0 allowed.
            response: one or several of "tool:+z", "location_3:-x", "tool:+ry"; the tool along z if none.
            reference: the same for the forces and moments; as `response` if none.
            form: receptance, mobility or inertance.

        Returns:
            A labelled FRF by line, response and reference.

        Raises:
            InvalidFrequencies, InvalidPoint, InvalidRequest: bad arguments.
            SingularResponse: an undamped mode is driven at its natural frequency.

        >>> import flexmodal
        >>> found = flexmodal.load("six_axis").at("work").frf([5.0, 10.0], response="tool:+z")
        >>> found.value.shape, found.unit()
        ((2, 1, 1), 'm/N')
        """
        axis = frequency_axis(frequencies)
        responses = self.directions(response)
        references = responses if reference is None else self.directions(reference)
        check_values(len(axis), len(responses), len(references))
        value = receptance(self.system, self.rows(responses), self.rows(references), axis)
        return Frf(axis, value, responses, references).to(form)

    def to_ss(
        self,
        *,
        response: Directions = None,
        reference: Directions = None,
        form: str = "receptance",
    ) -> LinearModel:
        """The state-space model between points and directions, for python-control, scipy and their like.

        Args:
            response: as for `frf`.
            reference: as for `frf`.
            form: receptance, mobility or inertance.

        Raises:
            InvalidPoint: bad directions.
            InvalidRequest: no such form, or joints with a loss factor.

        >>> import flexmodal, scipy
        >>> model = flexmodal.load("six_axis").at("work").to_ss(response="tool:+z")
        >>> A, B, C, D = model
        >>> A.shape
        (12, 12)
        >>> scipy.signal.StateSpace(*model).inputs
        1
        """
        rows, forces, names = self._ports(response, reference)
        return linear_model(self.system, rows, forces, derivative=POWER[check_form(form)], **names)

    def modal_ss(
        self, *, response: Directions = None, reference: Directions = None, keep: int | None = None
    ) -> LinearModel:
        """The state-space model of the receptance in blocks of one mode, perhaps of the first few alone.

        Args:
            response: as for `frf`.
            reference: as for `frf`.
            keep: how many modes; all if none.

        Raises:
            InvalidPoint: bad directions.
        """
        rows, forces, names = self._ports(response, reference)
        return model_of_modes(self.modes(), rows, forces, keep=keep, **names)

    def _ports(self, response: Directions, reference: Directions) -> tuple[Any, Any, dict[str, Any]]:
        """Rows of the outputs and the inputs of a linear model, and what they are called."""
        responses = self.directions(response)
        references = responses if reference is None else self.directions(reference)
        names = {"inputs": tuple(map(str, references)), "outputs": tuple(map(str, responses))}
        return self.rows(responses), self.rows(references), names

    def modes(self) -> Modes:
        """Modes over the flexible joints.

        >>> import flexmodal
        >>> modes = flexmodal.load("six_axis").at("work").modes()
        >>> modes.frequency.round(1).tolist()
        [12.5, 13.6, 22.6, 53.7, 60.4, 88.6]
        """
        return solve_modes(self.system)
