"""The checkout, which is no package; its folder often has the name of one.

Python, started in the folder above a clone, finds this folder for `import flexmodal`. Without this file it
would make an empty module of it and say nothing. With it the package inside is imported instead.
"""

if __name__ == "flexmodal":
    import importlib.util
    import sys
    from pathlib import Path

    _inside = Path(__file__).resolve().parent / "flexmodal"
    _spec = importlib.util.spec_from_file_location(
        __name__, _inside / "__init__.py", submodule_search_locations=[str(_inside)]
    )
    if _spec is None or _spec.loader is None:
        raise ImportError(f"no package in {_inside}")
    sys.modules[__name__] = _module = importlib.util.module_from_spec(_spec)
    try:
        _spec.loader.exec_module(_module)
    except ModuleNotFoundError as error:
        raise ImportError(
            f"flexmodal lies in {_inside.parent} and this Python has not installed what it needs "
            f"({error.name} is missing): {sys.executable} -m pip install --editable {_inside.parent}"
        ) from error
