"""Figures as text for a person: scalars a line each, rows as tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence


def lines(figures: Mapping[str, object], indent: str = "") -> Iterator[str]:
    """The figures in their order; nested ones are indented, lists of mappings become tables with aligned columns."""
    for name, value in figures.items():
        if isinstance(value, Mapping):
            yield f"{indent}{name}:"
            yield from lines(value, indent + "  ")
        elif isinstance(value, Sequence) and not isinstance(value, str):
            yield f"{indent}{name}:"
            rows = [row for row in value if isinstance(row, Mapping)]
            yield from _table(rows, indent + "  ") if rows else [f"{indent}  none"]
        else:
            yield f"{indent}{name}: {_text(value)}"


def _table(rows: Sequence[Mapping[str, object]], indent: str) -> Iterator[str]:
    names = list(dict.fromkeys(name for row in rows for name in row))
    cells = [names, *([_text(row.get(name, "")) for name in names] for row in rows)]
    widths = [max(len(line[column]) for line in cells) for column in range(len(names))]
    for line in cells:
        yield indent + "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))


def _text(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
