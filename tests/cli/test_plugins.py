"""A plug-in that fails is named, and the commands go on without it."""

import sys

import pytest

BROKEN = {
    "raises": ("raise RuntimeError('out of order')", "EFFECT", "RuntimeError: out of order"),
    "leaves": ("import sys; sys.exit(0)", "EFFECT", "SystemExit"),
    "is_gone": ("import package_that_is_not_there", "EFFECT", "package_that_is_not_there"),
    "lacks_it": ("", "EFFECT", "AttributeError"),
    "is_wrong": ("EFFECT = 7", "EFFECT", "int"),
    "is_no_python": ("def (", "EFFECT", "SyntaxError"),
}


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Put a distribution with one entry point on the path, and forget it afterwards."""

    def install(group, name, code, attribute):
        module = f"plugin_{name}"
        (tmp_path / f"{module}.py").write_text(code, encoding="utf-8")
        info = tmp_path / f"{module}-1.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1\n")
        (info / "entry_points.txt").write_text(f"[{group}]\n{name} = {module}:{attribute}\n")
        monkeypatch.syspath_prepend(str(tmp_path))
        return module

    yield install
    for module in [name for name in sys.modules if name.startswith("plugin_")]:
        del sys.modules[module]


@pytest.mark.parametrize("kind", BROKEN)
def test_an_effect_that_fails(installed, kind, caplog):
    from flexmodal.diagnosis.effects.catalogue import OWN, catalogue

    code, attribute, says = BROKEN[kind]
    installed("flexmodal.effects", kind, code, attribute)
    assert list(catalogue()) == [effect.name for effect in OWN]
    assert f"plug-in {kind} of flexmodal.effects is left out" in caplog.text
    assert says in caplog.text


@pytest.mark.parametrize("kind", BROKEN)
def test_another_viewer_that_fails(installed, kind, cli, tmp_path, caplog):
    code, attribute, says = BROKEN[kind]
    name = "show_robot"
    module = installed("flexmodal.viewer", name, code, attribute)
    ran = cli("show", "fanuc_s360", "--out", tmp_path / "page.html")
    assert ran.status == 0
    assert (tmp_path / "page.html").is_file()
    assert module in caplog.text
    assert says in caplog.text


def test_it_is_said_on_standard_error(installed, shell, tmp_path, monkeypatch):
    installed("flexmodal.viewer", "show_robot", "import sys; sys.exit(0)", "x")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    ran = shell("show", "fanuc_s360", "--out", "page.html")
    assert ran.status == 0
    assert "flexmodal: the plug-in show_robot of flexmodal.viewer is left out: " in ran.err
    assert "SystemExit" in ran.err
    assert "Traceback" not in ran.err
    assert (tmp_path / "page.html").is_file()
