"""A scene in a cell of a notebook."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

from flexmodal_viewer.page import page_html
from flexmodal_viewer.scene import Scene


@dataclass(frozen=True, eq=False)
class CellView:
    """A page that a notebook shows below the cell whose value it is, shut off from the notebook around it.

    >>> import flexmodal
    >>> from flexmodal_viewer import CellView, live_scene
    >>> robot = flexmodal.load("six_axis")
    >>> view = CellView(live_scene(robot, robot.posture("work")))
    >>> view._repr_html_()[:7]
    '<iframe'
    """

    scene: Scene
    height: int = 640
    """Of the cell [pixels]."""

    def _repr_html_(self) -> str:
        """What Jupyter shows."""
        page = escape(page_html(self.scene), quote=True)
        style = f"width: 100%; height: {int(self.height)}px; border: 1px solid #8884"
        title = escape(self.scene.caption.title, quote=True)
        return f'<iframe sandbox="allow-scripts" title="{title}" style="{style}" srcdoc="{page}"></iframe>'
