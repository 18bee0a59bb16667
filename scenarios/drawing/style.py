"""How a plan's drawing looks, on a light screen, a dark one, and in programs that know neither."""

from __future__ import annotations

_FILLS = ("#dbe8f8", "#dff0e0", "#fbe6d0", "#efe1f6", "#d9f0f0", "#f6e0e4", "#eee9cf", "#e3e6ea")
_LINES = ("#3d6fb0", "#3f8a4a", "#b8691c", "#8a4fa8", "#26858a", "#ad4a5e", "#857522", "#647080")
_DARK_FILLS = ("#213a5c", "#214a2c", "#5a3a17", "#46295a", "#184a4d", "#582934", "#4a421a", "#363d47")
_DARK_LINES = ("#7fabe6", "#7cc98a", "#e6a866", "#c999e6", "#6cc9ce", "#e68fa1", "#cdbb66", "#9aa6b5")
HUES = len(_FILLS)
_FACE = "'DejaVu Sans', Verdana, 'Segoe UI', system-ui, sans-serif"


def _hues(fills: tuple[str, ...], lines: tuple[str, ...]) -> str:
    return "".join(
        f".h{n} {{ fill: {fill}; stroke: {line}; }}\n" for n, (fill, line) in enumerate(zip(fills, lines, strict=True))
    )


def _theme(ink: str, soft: str, back: str, band: str, grid: str, accent: str, order: str) -> str:
    return f"""
text {{ fill: {ink}; stroke: none; }}
.back {{ fill: {back}; }}
.band {{ fill: {band}; }}
.grid {{ stroke: {grid}; }}
.tick, .key, .more {{ fill: {soft}; }}
.edge, .bound, .tick {{ stroke: {band}; }}
.edge {{ fill: {ink}; }}
.bound {{ fill: {ink}; stroke: {back}; }}
.hatch {{ stroke: {ink}; }}
.box.goal {{ stroke: {accent}; }}
text.goal {{ fill: {accent}; }}
.link {{ stroke: {soft}; }}
.link.order {{ stroke: {order}; }}
.tip-after, .tip-asked {{ fill: {soft}; }}
.tip-order {{ fill: {order}; }}
"""


_LIGHT = _theme("#1b2430", "#56616f", "#ffffff", "#f4f6f9", "#dfe4ea", "#b3123a", "#b8691c")
_DARK = _theme("#e8edf3", "#a3afbd", "#12171e", "#1a212b", "#2b3542", "#ff8fa6", "#e6a866")
STYLE = f"""
text {{ font-family: {_FACE}; font-size: 9px; }}
.title {{ font-size: 13px; font-weight: bold; }}
.lane {{ font-size: 11px; font-weight: bold; }}
.name {{ font-size: 11px; }}
.tick, .middle, .bound {{ text-anchor: middle; }}
.end {{ text-anchor: end; }}
.edge, .bound, .tick {{ paint-order: stroke; stroke-width: 4px; stroke-linejoin: round; }}
.grid {{ stroke-width: 0.6; }}
.fade {{ opacity: 0.6; }}
.hatch {{ stroke-width: 1.4; opacity: 0.16; }}
.box {{ stroke-width: 1; }}
.box.goal {{ stroke-width: 2; }}
.box.fact {{ stroke-dasharray: 4 2; }}
.link {{ fill: none; stroke-width: 1; opacity: 0.75; }}
.link.same {{ stroke-dasharray: 2 2; }}
.link.asked {{ stroke-dasharray: 1 3; }}
{_LIGHT}{_hues(_FILLS, _LINES)}
.box.goal {{ stroke: #b3123a; }}
@media (prefers-color-scheme: dark) {{
{_DARK}{_hues(_DARK_FILLS, _DARK_LINES)}
.box.goal {{ stroke: #ff8fa6; }}
}}
"""
