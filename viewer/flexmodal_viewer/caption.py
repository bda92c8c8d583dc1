"""The words of a page as HTML, every one of them escaped."""

from __future__ import annotations

from html import escape

from flexmodal_viewer.assets import asset
from flexmodal_viewer.palette import to_hex
from flexmodal_viewer.scene import Caption, Motion, Scene, Swatch, Table

_ICONS = {
    "solid": '<rect x="1" y="3" width="20" height="10" rx="2" fill="{0}"/>',
    "own": (
        '<rect x="1" y="3" width="7" height="10" fill="#456b91"/><rect x="8" y="3" width="7" height="10" '
        'fill="#c7a870"/><rect x="15" y="3" width="6" height="10" fill="#b36952"/>'
    ),
    "clear": '<rect x="1.5" y="3.5" width="19" height="9" rx="2" fill="{0}" fill-opacity=".4" stroke="{0}"/>',
    "arrow": '<path d="M1 8h13" stroke="{0}" stroke-width="3"/><path d="M12 2.5 21 8l-9 5.5z" fill="{0}"/>',
    "cross": '<path d="M11 1v14M3.5 8h15" stroke="{0}" stroke-width="3.4"/>',
    "dot": '<circle cx="11" cy="8" r="5" fill="{0}"/>',
}


def caption_html(scene: Scene) -> str:
    """The panel beside the picture."""
    caption = scene.caption
    parts = [f"<h1>{escape(caption.title)}</h1>"]
    if caption.subtitle:
        parts.append(f'<p class="subtitle">{escape(caption.subtitle)}</p>')
    parts.append(_buttons(scene))
    if scene.live is not None:
        parts.append(asset("live/panel.html"))
    parts.append(_legend(caption.legend))
    parts += [_of_motion(number, motion) for number, motion in enumerate(scene.motions)]
    parts += [_table(table) for table in caption.tables]
    parts.append(_notes(caption))
    return "\n".join(part for part in parts if part)


def _buttons(scene: Scene) -> str:
    names = [(number, motion.name) for number, motion in enumerate(scene.motions)]
    if scene.rest and names:
        names.insert(0, (-1, scene.rest))
    buttons = [
        f'<button type="button" data-motion="{number}" aria-pressed="false"'
        f"{' hidden' if len(names) == 1 else ''}>{escape(name)}</button>"
        for number, name in names
    ]
    extra = ['<button type="button" id="pause" hidden>Pause</button>'] if names else []
    extra.append('<button type="button" id="reset-view">Reset view</button>')
    rows = [buttons, extra] if len(names) > 1 else [buttons + extra]
    return "\n".join(f'<div class="bar">{"".join(row)}</div>' for row in rows)


def _of_motion(number: int, motion: Motion) -> str:
    inside = _legend(motion.legend) + (_table(motion.table) if motion.table else "")
    inside += "".join(f'<p class="note">{escape(note)}</p>' for note in motion.notes)
    return f'<section data-of="{number}" hidden>{inside}</section>'


def _legend(swatches: tuple[Swatch, ...]) -> str:
    if not swatches:
        return ""
    lines = "".join(
        f'<li><svg width="22" height="16" viewBox="0 0 22 16" aria-hidden="true">'
        f"{_ICONS[swatch.kind].format(to_hex(swatch.colour))}</svg><span>{escape(swatch.text)}</span></li>"
        for swatch in swatches
    )
    return f'<ul class="legend">{lines}</ul>'


def _table(table: Table) -> str:
    head = ""
    if table.columns:
        head = (
            "<thead><tr>"
            + "".join(f'<th scope="col">{escape(text)}</th>' for text in table.columns)
            + "</tr></thead>"
        )
    rows = "".join(
        "<tr>"
        + f'<th scope="row">{escape(row[0])}</th>'
        + "".join(f"<td>{escape(text)}</td>" for text in row[1:])
        + "</tr>"
        for row in table.rows
    )
    return f"<h2>{escape(table.heading)}</h2><table>{head}<tbody>{rows}</tbody></table>"


def _notes(caption: Caption) -> str:
    if not caption.notes:
        return ""
    return "<h2>Notes</h2>" + "".join(f'<p class="note">{escape(note)}</p>' for note in caption.notes)
