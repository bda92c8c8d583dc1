"""A page is one file, says nothing it should not, and stands whole or not at all."""

import json
import re
import socket

import pytest
from flexmodal_viewer import outcome_scene, robot_scene, show_outcome, show_robot, write_page
from flexmodal_viewer.page import page_html

from flexmodal.errors import OutputExists

HOSTILE = "&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;&lt;img src=x onerror=alert(2)&gt;"
"""As XML; the name itself is </script><script>alert(1)</script><img src=x onerror=alert(2)>."""


def own_part(page):
    """A page without the viewer's own script."""
    return re.sub(r"<script>\s*/\*! For license.*?</script>", "", page, flags=re.DOTALL)


@pytest.fixture
def page(outcome, six_link):
    return page_html(outcome_scene(outcome, start=six_link.posture("start_3")))


def test_needs_nothing_else(page):
    assert "default-src 'none'" in page
    own = own_part(page)
    assert len(own) < len(page) - 500_000
    assert not re.findall(r"""(?:src|href)\s*=\s*["']?\s*(?!#)[\w/]""", own)
    assert "http:" not in own.replace("http://opensource.org/licenses/MIT", "").replace(
        "http://kawanet.github.io/event-lite/EventLite.html", ""
    )


def test_is_the_same_each_time(outcome, six_link, page):
    assert page_html(outcome_scene(outcome, start=six_link.posture("start_3"))) == page


def test_licences_of_what_is_inside_are_inside(page):
    assert "Three.js Authors" in page
    assert "Robin Deits" in page


def test_names_from_files_are_text(bare):
    robot = bare(name=HOSTILE, link=HOSTILE, joint=HOSTILE)
    page = page_html(robot_scene(robot, robot.posture({}), modes=True))
    assert "<script>alert" not in page
    assert "<img" not in own_part(page)
    assert "&lt;script&gt;alert(1)" in page  # it is shown, though
    blocks = re.findall(r"<script[^>]*>(.*?)</script>", page, flags=re.DOTALL)
    assert len(blocks) == 4
    json.loads(blocks[0])


def test_braces_in_names_are_not_filled_in(bare):
    robot = bare(name="{{js}} {{scene}}")
    page = page_html(robot_scene(robot, robot.posture({})))
    assert "{{js}} {{scene}}" in page


def test_pictures_that_meshes_name_stay_out(bare, tmp_path):
    secret = tmp_path / "private.png"
    secret.write_bytes(b"\x89PNG\r\n\x1a\nTOPSECRETTOPSECRETTOPSECRET")
    (tmp_path / "part.mtl").write_text(f"newmtl skin\nKd 0.1 0.9 0.1\nmap_Kd {secret}\n")
    (tmp_path / "part.obj").write_text(
        "mtllib part.mtl\nusemtl skin\nv 0 0 0\nv 0.3 0 0\nv 0 0.3 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"
    )
    (tmp_path / "part.dae").write_text(_COLLADA.format(image=secret.as_uri()))
    parts = "".join(
        f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
        for name in ("part.obj", "part.dae")
    )
    robot = bare(arm=parts)
    scene = robot_scene(robot, robot.posture({}))
    assert sum(type(item.shape).__name__ == "Mesh" for item in scene.items) == 2
    page = page_html(scene)
    for trace in ("private.png", "TOPSECRET", "VE9QU0VDUkVU", "data:image", str(tmp_path)):
        assert trace not in own_part(page)


@pytest.mark.parametrize("name", ["../../../../etc/passwd", "/etc/passwd", "file:///etc/passwd", "gone.stl"])
def test_files_that_are_no_meshes_stay_out(bare, name):
    robot = bare(arm=f'<visual><geometry><mesh filename="{name}"/></geometry></visual>')
    page = page_html(robot_scene(robot, robot.posture({})))
    assert "root:" not in own_part(page)
    assert "A part of arm is not shown" in page
    assert "/etc" not in own_part(page)


@pytest.mark.parametrize("content", [b"", b"solid nothing", b"\x00" * 84, b"solid x\nfacet normal a b c\n"])
def test_broken_meshes_are_named(bare, tmp_path, content):
    (tmp_path / "broken.stl").write_bytes(content)
    robot = bare(arm='<visual><geometry><mesh filename="broken.stl"/></geometry></visual>')
    assert "broken.stl" in page_html(robot_scene(robot, robot.posture({})))


def test_nothing_on_the_network_while_writing(outcome, tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("a socket was opened")

    monkeypatch.setattr(socket, "socket", refuse)
    said = []
    path = show_outcome(outcome, start=None, out=tmp_path / "page.html", announce=said.append)
    assert path == str(tmp_path / "page.html")
    assert said == [f"Written to {path}"]


def test_an_existing_page_is_kept(fanuc, tmp_path):
    path = tmp_path / "page.html"
    path.write_text("mine")
    with pytest.raises(OutputExists):
        show_robot(fanuc, fanuc.posture("configuration_1"), out=path, announce=lambda _: None)
    assert path.read_text() == "mine"
    show_robot(fanuc, fanuc.posture("configuration_1"), out=path, overwrite=True, announce=lambda _: None)
    assert path.read_text().startswith("<!DOCTYPE html>")


def test_a_page_that_fails_leaves_nothing(fanuc, tmp_path, monkeypatch):
    def fail(_):
        raise RuntimeError

    monkeypatch.setattr("flexmodal_viewer.page.page_html", fail)
    with pytest.raises(RuntimeError):
        write_page(robot_scene(fanuc, fanuc.posture("configuration_1")), tmp_path / "page.html")
    assert list(tmp_path.iterdir()) == []


_COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.1"/><up_axis>Z_UP</up_axis></asset>
<library_images><image id="i"><init_from>{image}</init_from></image></library_images>
<library_effects><effect id="e"><profile_COMMON>
<newparam sid="s"><surface type="2D"><init_from>i</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="c"><lambert><diffuse><texture texture="t" texcoord="UV"/></diffuse></lambert></technique>
</profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<source id="u"><float_array id="ua" count="6">0 0 1 0 0 1</float_array><technique_common>
<accessor source="#ua" count="3" stride="2"><param name="S" type="float"/><param name="T" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1" material="k"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#u" offset="1" set="0"/><p>0 0 1 1 2 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="k" target="#m"/></technique_common></bind_material>
</instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>"""


def test_collada_in_other_units_comes_in_metres(bare, tmp_path):
    (tmp_path / "part.dae").write_text(_COLLADA.format(image="none.png"))
    robot = bare(arm='<visual><geometry><mesh filename="part.dae"/></geometry></visual>')
    scene = robot_scene(robot, robot.posture({}))
    (mesh,) = [item.shape for item in scene.items if type(item.shape).__name__ == "Mesh"]
    assert mesh.vertices.max() == pytest.approx(0.1)  # one unit of 0.1 m
