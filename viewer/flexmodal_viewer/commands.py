"""A scene as the commands and animations that meshcat's viewer takes, ready for JSON."""

from __future__ import annotations

import base64
import hashlib
import uuid
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from flexmodal_viewer.palette import to_hex
from flexmodal_viewer.scene import Item, Matrix, Motion, Scene

CYCLE = 1.6
"""How long one cycle lasts on the page, whatever the frequency [s]."""

FIELD_OF_VIEW = 22.0
"""Narrow, so that lengths near and far can be compared [degrees]."""

_DIGITS = 6


@dataclass
class _Store:
    """Arrays by name, each once."""

    texts: dict[str, str] = field(default_factory=dict)

    def add(self, array: np.ndarray) -> dict[str, str]:
        """Store an array under a name that follows from what is in it."""
        content = np.ascontiguousarray(array).tobytes()
        name = hashlib.sha256(content).hexdigest()[:20]
        if name not in self.texts:
            self.texts[name] = base64.b64encode(content).decode()
        return {"buffer": name}


def payload(scene: Scene) -> dict[str, Any]:
    """Everything the page's script needs."""
    store = _Store()
    commands = [*_surroundings(scene)]
    rough = [item for item in scene.items if item.rough is not None]
    commands += [_set_object(item, store) for item in scene.items]
    commands += [_set_object(_roughly(item), store) for item in rough]
    commands += [
        {"type": "set_transform", "path": _path(path), "matrix": _flat(place)}
        for path, place in scene.nodes.items()
    ]
    return {
        "commands": commands,
        "arrays": store.texts,
        "rough": [[_path(item.path), _path(_roughly(item).path)] for item in rough],
        "labels": [
            {"text": label.text, "path": _path(label.path), "kind": label.kind} for label in scene.labels
        ],
        "motions": [_motion(motion) for motion in scene.motions],
        "rest": bool(scene.rest) or not scene.motions,
        "view": {
            "look": list(scene.view.look),
            "flat": scene.view.flat,
            "fov": FIELD_OF_VIEW,
            "points": np.unique(scene.corners.round(4), axis=0).tolist(),
        },
    }


def _roughly(item: Item) -> Item:
    """The same in its rough shape, beside the other."""
    return replace(item, path=f"{item.path}_rough", shape=item.rough or item.shape, framed=False)


def _path(path: str) -> str:
    return f"/flexmodal/{path}"


def _flat(matrix: Matrix) -> list[float]:
    return [float(value) for value in matrix.T.round(_DIGITS + 3).flatten()]


def _surroundings(scene: Scene) -> list[dict[str, Any]]:
    """White ground, no grid and axes but our own, light from where the camera is."""
    look = np.array(scene.view.look) / np.linalg.norm(scene.view.look)
    lamp = (-10 * look + np.array([-3.0, -2.0, 7.0])).tolist()
    values = [
        ("/Background", "visible", False),
        ("/Grid", "visible", False),
        ("/Axes", "visible", False),
        ("/Lights/PointLightNegativeX", "visible", False),
        ("/Lights/PointLightPositiveX", "visible", False),
        ("/Lights/AmbientLight/<object>", "intensity", 0.58),
        ("/Lights/FillLight/<object>", "intensity", 0.46),
        ("/Lights/FillLight/<object>", "position", lamp),
    ]
    return [
        {"type": "set_property", "path": path, "property": key, "value": value} for path, key, value in values
    ]


def _set_object(item: Item, store: _Store) -> dict[str, Any]:
    names = {part: str(uuid.uuid5(uuid.NAMESPACE_URL, f"{item.path}#{part}")) for part in ("g", "m", "o")}
    lines = item.shape.kind == "LineSegments"
    material: dict[str, Any] = {
        "uuid": names["m"],
        "type": "LineBasicMaterial"
        if lines
        else ("MeshBasicMaterial" if item.on_top else "MeshPhongMaterial"),
        "color": int(to_hex(item.colour)[1:], 16),
        "opacity": item.opacity,
        "transparent": item.opacity < 1 or item.on_top,
        "depthTest": not item.on_top,
        "depthWrite": item.opacity == 1 and not item.on_top,
    }
    if not lines and not item.on_top:
        material |= {
            "flatShading": item.flat,
            "side": 2 if item.flat else 0,
            "shininess": 12,
            "specular": 0x1A1A1A,
        }
    if item.opacity < 1:  # where it coincides with something solid, the solid is seen
        material |= {"polygonOffset": True, "polygonOffsetFactor": 1.0, "polygonOffsetUnits": 4.0}
    return {
        "type": "set_object",
        "path": _path(item.path),
        "object": {
            "metadata": {"version": 4.5, "type": "Object"},
            "geometries": [{"uuid": names["g"], **item.shape.geometry(store)}],
            "materials": [material],
            "object": {
                "uuid": names["o"],
                "type": item.shape.kind,
                "geometry": names["g"],
                "material": names["m"],
                "matrix": _flat(item.place @ item.shape.turn),
                "renderOrder": 10 if item.on_top else 0,
            },
        },
    }


def _motion(motion: Motion) -> dict[str, Any]:
    return {
        "animations": [_animation(path, track) for path, track in motion.tracks.items()],
        "shows": [_path(path) for path in motion.shows],
        "poses": [[_path(path), _flat(place)] for path, place in motion.poses.items()],
        "duration": CYCLE,
        "extreme": round(motion.extreme, _DIGITS),
    }


def _animation(path: str, track: Float[np.ndarray, "frame 4 4"]) -> dict[str, Any]:
    turns = Rotation.from_matrix(track[:, :3, :3]).as_quat()
    for frame in range(1, len(turns)):
        if turns[frame - 1] @ turns[frame] < 0:  # one rotation, but the long way round
            turns[frame] *= -1
    rate = (len(track) - 1) / CYCLE

    def keys(values: np.ndarray) -> list[dict[str, Any]]:
        return [{"time": frame, "value": value} for frame, value in enumerate(values.round(_DIGITS).tolist())]

    return {
        "path": _path(path),
        "clip": {
            "fps": rate,
            "name": "cycle",
            "tracks": [
                {"name": ".position", "type": "vector3", "keys": keys(track[:, :3, 3])},
                {"name": ".quaternion", "type": "quaternion", "keys": keys(turns)},
            ],
        },
    }
