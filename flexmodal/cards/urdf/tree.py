"""Whether links and joints make one tree."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from flexmodal.cards.urdf.urdf import UrdfJoint
from flexmodal.text.words import FaultList, listing, nearest


def find_root(links: Collection[str], joints: Mapping[str, UrdfJoint], faults: FaultList) -> str:
    """The link that carries all others.

    Args:
        links: names of the links, at least one.
        joints: the joints by name.
        faults: where dangling ends, second parents, loops and several roots go.

    Returns:
        The root, or any link where there is a fault.
    """
    parents: dict[str, str] = {}
    whole = not any(fault.key == "joint" or fault.key.startswith("joint.") for fault in faults.faults)
    for name, joint in joints.items():
        for tag, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in links:
                allowed = f"{nearest(link, links)}a link of this file"
                faults.add(f"joint.{name}.{tag}", f'"{link}", which no <link> is called', allowed)
                whole = False
        if joint.child in parents:
            first = parents[joint.child]
            found = f'"{joint.child}", which joint "{first}" already carries'
            faults.add(f"joint.{name}.child", found, "a link with one parent")
        else:
            parents[joint.child] = name
    carriers = {link: joints[name].parent for link, name in parents.items()}
    _refuse_loops(carriers, faults)
    roots = [link for link in links if link not in parents]
    if len(roots) > 1 and whole:  # else the faults of the joints are what leaves links loose
        found = f"{len(roots)} links that no joint carries: {listing(roots[:10])}"
        faults.add("robot", found, "one root, with every other link joined to it")
    return next(iter(roots or links))


def _refuse_loops(carriers: Mapping[str, str], faults: FaultList) -> None:
    """Add a fault for each ring of links; `carriers` maps a link to the one that carries it."""
    done: set[str] = set()
    for start in carriers:
        path: list[str] = []
        link: str | None = start
        while link is not None and link not in done:
            done.add(link)
            path.append(link)
            link = carriers.get(link)
        if link is not None and link in path:
            ring = path[path.index(link) :]
            found = f"a loop of links: {listing([*ring[:10], link])}"
            faults.add("robot", found, "a tree, in which no link carries itself")
