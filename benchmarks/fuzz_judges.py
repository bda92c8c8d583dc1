"""Second readers: what the program accepted, read by something else and compared, number by number."""

from __future__ import annotations

import csv
import io
import math
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

import flexmodal

ROOT = Path(__file__).parents[1]
CLOSE = 1e-9
"""Relative difference of two readers that is rounding."""


class Misread(AssertionError):
    """The program did what it may not."""


URDF = (ROOT / "urdf" / "fanuc_s360.urdf").read_bytes()
CARD = re.sub(
    rb'(?m)^urdf = ".*"', b'urdf = "arm.urdf"', (ROOT / "robots" / "fanuc_s360" / "robot.toml").read_bytes()
)
CUT = (ROOT / "robots" / "fanuc_s360" / "cuts" / "aluminium.toml").read_bytes()
TOOLPATH = b"x,z,fx,fz\n0.9,0.6,1,0\n0.92,0.62,1,0.5\n0.95,0.65,0,1\n"
AT = ("--posture", "q1=1.2,q2=-0.6,q3=-0.3", "--json")
SOUND: dict[str, tuple[bytes, str, tuple[str, ...]]] = {
    "urdf": (URDF, "arm.urdf", ("measures", "FOLDER/robot.toml", *AT)),
    "card": (CARD, "robot.toml", ("measures", "FOLDER/robot.toml", *AT)),
    "cut": (CUT, "cut.toml", ("lobes", "fanuc_s360", "--cut", "FOLDER/cut.toml", "--speeds", "5", *AT)),
    "toolpath": (
        TOOLPATH,
        "path.csv",
        ("path", "fanuc_s360", "--toolpath", "FOLDER/path.csv", "--feed", "0.1", "--frequency", "5",
        "--stride", "3",
         "--json", "--quiet"),
    ),
}  # fmt: skip
"""A sound file of each target, its name, and the command that reads it."""


def judge_urdf(path: Path, told: dict[str, Any]) -> None:
    """Every number of links and joints again by lxml; masses and inertias as any body's."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, recover=False)
    try:
        root = etree.parse(str(path), parser).getroot()
    except etree.XMLSyntaxError as error:
        raise Misread(f"no XML: {error}") from error
    robot = told.get("_read") or flexmodal.load(path.with_name("robot.toml"))
    links = {one.get("name"): one for one in root.findall("link")}
    joints = {one.get("name"): one for one in root.findall("joint")}
    if len(links) != len(root.findall("link")) or len(joints) != len(root.findall("joint")):
        raise Misread("a name twice")
    for name, joint in robot.moving.items():
        element = joints[name]
        read = _three(element.find("origin"), "xyz", (0, 0, 0))
        _same(f"origin of {name}", joint.xyz, read)
        _same(f"rpy of {name}", joint.rpy, _three(element.find("origin"), "rpy", (0, 0, 0)))
        axis = np.array(_three(element.find("axis"), "xyz", (1, 0, 0)))
        if not np.linalg.norm(axis) > 0:
            raise Misread(f"an axis of length 0 at {name}")
        _same(f"axis of {name}", joint.axis, axis / np.linalg.norm(axis))
        limit = element.find("limit")
        if element.get("type") in ("revolute", "prismatic"):
            _same(
                f"limits of {name}",
                (joint.lower, joint.upper),
                (float(limit.get("lower", 0)), float(limit.get("upper", 0))),
            )
    total = sum(
        float(one.find("inertial/mass").get("value"))
        for one in links.values()
        if one.find("inertial") is not None
    )
    moving = {joint.get("name"): joint for joint in root.findall("joint") if joint.get("type") != "fixed"}
    if set(robot.moving) - set(moving):
        raise Misread("a joint that moves only here")
    for name, link in links.items():
        if link.find("inertial/inertia") is not None:
            entries = {key: float(value) for key, value in link.find("inertial/inertia").attrib.items()}
            matrix = np.array([
                [entries["ixx"], entries["ixy"], entries["ixz"]],
                [entries["ixy"], entries["iyy"], entries["iyz"]],
                [entries["ixz"], entries["iyz"], entries["izz"]],
            ])  # fmt: skip
            moments = np.linalg.eigvalsh(matrix)
            if moments[0] < -1e-9 * moments[-1] or moments[0] + moments[1] < moments[-1] * (1 - 1e-6):
                raise Misread(f"no body has the moments {moments} of {name}")
    if not 0 < total < math.inf:
        raise Misread(f"a mass of {total}")
    _compare_statics(root, tomllib.loads(path.with_name("robot.toml").read_text(encoding="utf-8")), told)
    _finite(told)


def _compare_statics(root: Any, card: dict[str, Any], told: dict[str, Any]) -> None:
    """Place of the tool and static receptance, from the elements and the card's stiffness alone."""
    posture = {name: float(value) for name, value in (part.split("=") for part in AT[1].split(","))}
    into = {joint.find("child").get("link"): joint for joint in root.findall("joint")}
    chain, link = [], card.get("tool", "tool")
    while link in into:
        chain.append(into[link])
        link = into[link].find("parent").get("link")
    if len(chain) > len(into):
        raise Misread("links in a circle")
    turned, place, joints = np.eye(3), np.zeros(3), []
    for joint in reversed(chain):
        origin = joint.find("origin")
        place = place + turned @ np.array(_three(origin, "xyz", (0, 0, 0)))
        roll, pitch, yaw = _three(origin, "rpy", (0, 0, 0))
        turned = turned @ _turn((0, 0, 1), yaw) @ _turn((0, 1, 0), pitch) @ _turn((1, 0, 0), roll)
        kind, name = joint.get("type"), joint.get("name")
        if kind == "fixed":
            continue
        axis = np.array(_three(joint.find("axis"), "xyz", (1, 0, 0)))
        axis = axis / np.linalg.norm(axis)
        joints.append((name, kind, turned @ axis, place))
        value = posture.get(name, 0.0)
        if kind == "prismatic":
            place = place + turned @ axis * value
        else:
            turned = turned @ _turn(tuple(axis), value)
    _same("place of the tool", told["tool"], place, scale=1 + float(np.abs(place).max()))
    compliance = 0.0
    for name, kind, axis, origin in joints:
        if name in card["joint"]:
            along = axis[2] if kind == "prismatic" else np.cross(axis, place - origin)[2]
            compliance += along**2 / float(card["joint"][name]["stiffness"])
    if not card.keys() & {"coupling"}:
        _same("static receptance", [told["static_receptance"]], [compliance], scale=compliance + 1e-12)


def _turn(axis: tuple[float, ...], angle: float) -> np.ndarray:
    """Rodrigues' rotation about a unit vector."""
    x, y, z = axis
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * across + (1 - math.cos(angle)) * across @ across


def judge_card(path: Path, told: dict[str, Any]) -> None:
    """Every number of the joints again by tomllib."""
    content = tomllib.loads(path.read_text(encoding="utf-8"))
    robot = told.get("_read") or flexmodal.load(path)
    if list(content["joint"]) and set(content["joint"]) != set(robot.joints):
        raise Misread(f"joints {sorted(content['joint'])} read as {sorted(robot.joints)}")
    for name, joint in content["joint"].items():
        for key in ("stiffness", "damping"):
            _same(f"{key} of {name}", [getattr(robot.joints[name], key)], [float(joint[key])])
        _same(f"loss of {name}", [robot.joints[name].loss_factor], [float(joint.get("loss_factor", 0))])
        if not float(joint["stiffness"]) > 0 or float(joint["damping"]) < 0:
            raise Misread(f"{name}: stiffness {joint['stiffness']}, damping {joint['damping']}")
        unknown = set(joint) - {
            "stiffness",
            "damping",
            "pseudo",
            "rotor_inertia",
            "loss_factor",
            "lower",
            "upper",
            "scale",
        }
        if unknown:
            raise Misread(f"{name}: {sorted(unknown)} passed")
    for name, values in content.get("posture", {}).items():
        for joint, value in values.items():
            if joint in robot.commanded and isinstance(value, int | float):
                _same(f"posture {name}", [robot.postures[name][joint]], [float(value)])
    for name, point in content.get("point", {}).items():
        _same(f"point {name}", robot.points[name].xyz, point.get("xyz", (0.0, 0.0, 0.0)))
        if point["link"] not in {link.name for link in robot.urdf.links}:
            raise Misread(f"point {name} on no link")
    root = etree.parse(str(path.with_name("arm.urdf")), etree.XMLParser(resolve_entities=False)).getroot()
    _compare_statics(root, content, told)
    _finite(told)


def judge_cut(path: Path, told: dict[str, Any]) -> None:
    """The numbers of the cut again by tomllib, and the depths positive."""
    content = tomllib.loads(path.read_text(encoding="utf-8"))
    cut = told.get("_read") or flexmodal.read_cut(path)
    _same("diameter", [cut.cutter.diameter], [content["cutter"]["diameter"]])
    _same("teeth", [cut.cutter.teeth], [content["cutter"]["teeth"]])
    _same("force", [cut.force.tangential], [content["force"]["tangential"]])
    _same("speeds", cut.engagement.spindle_speed, content["engagement"]["spindle_speed"])
    if len(cut.modes) != len(content.get("mode", [])):
        raise Misread("a mode lost")
    for one, given in zip(cut.modes, content.get("mode", []), strict=True):
        _same(
            "mode",
            [one.frequency, one.damping_ratio, one.stiffness],
            [given["frequency"], given["damping_ratio"], given["stiffness"]],
        )
    if not math.isfinite(cut.force.tangential) or cut.cutter.teeth < 1:
        raise Misread("a cut that is none")
    _finite(told)


def judge_toolpath(path: Path, told: dict[str, Any]) -> None:
    """The rows again by the csv module."""
    from flexmodal.optimisation.path import read_toolpath

    text = path.read_bytes().decode("utf-8-sig")
    rows = [row for row in csv.reader(io.StringIO(text, newline="")) if any(cell.strip() for cell in row)]
    names = [name.strip().lower() for name in rows[0]]
    read = told.get("_read") or read_toolpath(path, planar=True, feed=0.1)
    numbers = np.array([[float(cell) for cell in row] for row in rows[1:]])
    if len(set(names)) != len(names) or not np.all(np.isfinite(numbers)):
        raise Misread("a column twice, or a number that is none")
    place = read.position
    if len(place) != len(numbers):
        raise Misread(f"{len(numbers)} rows read as {len(place)}")
    wanted = [names.index(name) for name in "xyz" if name in names]
    _same("places", place.ravel(), numbers[:, wanted].ravel())
    _finite(told)


def judge_posture(text: str, told: dict[str, Any], robot: flexmodal.Robot) -> None:
    """The grammar by a pattern of its own, the limits by the URDF's, the place by the angles read here."""
    if "=" not in text:
        if text not in robot.postures:
            raise Misread(f"{text!r} is no posture")
        return
    values: dict[str, float] = {}
    for part in text.split(","):
        found = re.fullmatch(r"\s*([^=]+?)\s*=\s*([^=]*?)\s*", part)
        if not found or found[1] in values or found[1] not in robot.commanded:
            raise Misread(f"{part!r} passed")
        plain = found[2].removesuffix("deg")
        values[found[1]] = math.radians(float(plain)) if plain != found[2] else float(plain)
    for name, joint in robot.commanded.items():
        value = values.get(name, 0.0)
        if not math.isfinite(value) or not joint.lower - 1e-6 <= value <= joint.upper + 1e-6:
            raise Misread(f"{name} = {value} is outside the limits")
    _same("tool", told["tool"], robot.at(values).position(robot.tool))


def judge_arguments(words: list[str], told: Any) -> None:
    """What is answered is finite, and belongs to the robot that was asked for."""
    _finite(told)
    if (
        isinstance(told, dict)
        and "robot" in told
        and words[1] in ("fanuc_s360", "six_link", "six_axis")
        and told["robot"] != words[1]
    ):
        raise Misread(f"{words[1]} asked, {told['robot']} answered")


def _three(element: Any, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
    text = None if element is None else element.get(key)
    return default if text is None else tuple(float(one) for one in text.split())


def _same(what: str, ours: Any, theirs: Any, *, scale: float = 1e-3) -> None:
    one, other = np.asarray(ours, dtype=float), np.asarray(theirs, dtype=float)
    if one.shape != other.shape or not np.allclose(one, other, rtol=CLOSE, atol=CLOSE * scale):
        raise Misread(f"{what}: {one.tolist()} here, {other.tolist()} by the other reader")


def _finite(told: Any) -> None:
    if isinstance(told, dict):
        for value in told.values():
            _finite(value)
    elif isinstance(told, list):
        for value in told:
            _finite(value)
    elif isinstance(told, float) and not math.isfinite(told):
        raise Misread("a number that is not finite")


JUDGES: dict[str, Callable[..., None]] = {
    "urdf": judge_urdf, "card": judge_card, "cut": judge_cut, "toolpath": judge_toolpath,
    "posture": judge_posture,
    "arguments": judge_arguments,
}  # fmt: skip
