"""Meshes with fewer triangles look the same, and a page of any shipped arm can be sent by mail."""

from typing import ClassVar

import numpy as np
import pytest
import trimesh
from flexmodal_viewer import live_scene
from flexmodal_viewer.commands import payload
from flexmodal_viewer.page import page_html
from flexmodal_viewer.palette import PLAIN
from flexmodal_viewer.shapes import Box, Mesh
from flexmodal_viewer.thinner import FEW_FACES, MOST_FACES, thinned
from flexmodal_viewer.visuals import Visual

from flexmodal.model import load

SMALL = 2_000_000
"""A page of an arm [bytes]."""


def part(mesh):
    return Visual("link", mesh, np.eye(4), PLAIN)


def ball(subdivisions, *, torn=False):
    made = trimesh.creation.icosphere(subdivisions)
    if torn:  # each triangle with corners of its own, as in a file that knows no shared ones
        return Mesh(made.vertices[made.faces].reshape(-1, 3), np.arange(3 * len(made.faces)).reshape(-1, 3))
    return Mesh(np.array(made.vertices), np.array(made.faces))


@pytest.mark.parametrize("torn", [False, True])
def test_a_ball_stays_a_ball(torn):
    before = ball(6, torn=torn)
    (after,) = thinned([part(before)])
    assert len(before.faces) > MOST_FACES
    assert 0.5 * MOST_FACES < len(after.shape.faces) <= 1.01 * MOST_FACES
    radius = np.linalg.norm(after.shape.vertices, axis=1)
    assert np.max(np.abs(radius - 1)) < 2e-3


def test_what_is_small_stays_as_it_is():
    parts = [part(ball(2)), part(Box((1.0, 2.0, 3.0)))]
    assert thinned(parts) == tuple(parts)
    small, large = thinned([part(ball(1)), part(ball(6))])
    assert len(small.shape.faces) == 80
    assert len(large.shape.faces) <= MOST_FACES


def test_places_survive_the_packing():
    mesh = ball(4)

    class Kept:
        arrays: ClassVar = []

        def add(self, array):
            self.arrays.append(array)
            return {"buffer": "x"}

    kept = Kept()
    position = mesh.geometry(kept)["data"]["attributes"]["position"]
    back = np.array(position["low"]) + np.array(position["step"]) * kept.arrays[0]
    assert np.max(np.abs(back - mesh.vertices)) < 2 / 65535


@pytest.mark.parametrize(
    "name", ["six_axis", "fanuc_s360", "panda", pytest.param("so101", marks=pytest.mark.slow)]
)
def test_pages_are_small(name):
    cards = {"six_axis", "fanuc_s360"}
    arm = load(name) if name in cards else load(name, stiffness=2e4, damping=20.0)
    middle = {joint: (one.lower + one.upper) / 2 for joint, one in arm.commanded.items()}
    assert len(page_html(live_scene(arm, arm.posture(middle))).encode()) < SMALL


def test_a_rough_arm_has_few_triangles():
    parts = [part(ball(5)), part(ball(4)), part(ball(1))]
    after = thinned(parts, FEW_FACES)
    assert sum(len(one.shape.faces) for one in after) <= 1.1 * FEW_FACES
    assert after[2] is parts[2]


def test_an_arm_stands_in_all_its_triangles_and_is_translucent_in_few(bare, tmp_path):
    trimesh.creation.icosphere(5).export(tmp_path / "ball.stl")
    arm = bare(arm='<visual><geometry><mesh filename="ball.stl"/></geometry></visual>')
    scene = live_scene(arm, arm.posture({}))
    parts = [item for item in scene.items if "/part_" in item.path]
    (own,) = [item for item in parts if item.path.startswith("arm/")]
    (ghost,) = [item for item in parts if item.path.startswith("rest/")]
    assert len(own.shape.faces) > FEW_FACES > 0.9 * len(own.rough.faces)
    assert ghost.shape is not own.shape
    assert ghost.rough is None
    assert len(ghost.shape.faces) == len(own.rough.faces)
    assert payload(scene)["rough"] == [[f"/flexmodal/{own.path}", f"/flexmodal/{own.path}_rough"]]
