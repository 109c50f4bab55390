"""Draws plots as SVG: reads their description as JSON from standard input.

What the description holds is said by plot.hpp. `pierce` has this file and plot_looks.py inside and
gives them to Python. Ends with NO_MATPLOTLIB where matplotlib is missing.
"""

import itertools
import json
import math
import os
import sys
import textwrap
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from plot_looks import (
    BAND,
    CYCLE,
    CYCLE_MARKERS,
    DARK,
    DASHES,
    FONT,
    INK,
    LOOKS,
    PALE,
    SETTINGS,
    TITLE_FONT,
    Look,
)

NO_MATPLOTLIB = 3
try:
    import matplotlib
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator
except ImportError:
    sys.exit(NO_MATPLOTLIB)

POINTS = 72  # [1/inch]
# Sizes [points; of figures: inches].
AXES_WIDTH, AXES_HEIGHT, PANEL_HEIGHT, PANEL_GAP = 5.4, 3.7, 2.7, 0.22
CELL_WIDTH, CELL_HEIGHT, BAR_WIDTH = 0.78, 0.5, 0.15
MAP_WIDTH, MAP_HEIGHT = 3.2, 2.0  # at least
THICKEST, THINNEST = 2.4, 1.2  # lines: the first is under the others, and seen beside them
LARGEST, SMALLEST = 9.0, 4.0  # markers of lines, for the same reason
POINT, LARGE_POINT = 9.0, 15.0  # markers of a scatter
LEGEND_WIDTH = 2.4

EACH_MARKED = 12  # points of a line of which each has a marker
MARKED = 8  # markers of a longer line
MOST_STEPS = 7  # between ticks of a linear axis
LETTER, BOLD_LETTER, LINE_HEIGHT = 0.62, 0.72, 1.8  # [font size] of many letters, on average
TICK_GAP = 6  # [points]
BAND_PART = 0.13  # of a logarithmic axis: where zeros stand
LEAST_DECADES = 0.5  # of a logarithmic axis
MARGIN_PART = 0.06  # of a logarithmic axis, free at its ends


def wrapped(text: str, width: float, size: float = FONT, letter: float = LETTER) -> str:
    """Text in lines of at most a width [inches]."""
    columns = int(width * POINTS / (letter * size))
    return "\n".join(textwrap.wrap(text, columns, break_on_hyphens=False)) or text


def number(value: float) -> str:
    """A number as people read it: 0.05, 200, 2·10⁻⁷."""
    if value == 0 or 1e-3 <= abs(value) < 1e6:
        return f"{value + 0.0:g}"  # not -0
    digits, exponent = f"{value:.3e}".split("e")
    power = "10" + str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return power if float(digits) == 1 else f"{float(digits):g}·{power}"


NUMBERS = FuncFormatter(lambda value, _: number(value))


def size_of(axes: Axes) -> tuple[float, float]:
    """Width and height [inches]."""
    return axes.bbox.width / axes.figure.dpi, axes.bbox.height / axes.figure.dpi


class LogAxis:
    """Sets up a logarithmic axis on which zeros, if there are any, stand in a band before it."""

    def __init__(
        self, axes: Axes, which: str, values: Iterable[float], zero_name: str, own: bool = False
    ) -> None:
        """`which`: x or y. `own`: ticks are at the values themselves, if there is room."""
        known = [v for v in values if math.isfinite(v) and v >= 0]
        positive = [v for v in known if v > 0] or [1.0, 10.0]
        low, high = math.log10(min(positive)), math.log10(max(positive))
        margin = max(MARGIN_PART * (high - low), (LEAST_DECADES - (high - low)) / 2)
        low, high = low - margin, high + margin
        start, self.zero = low, math.nan
        zeros: list[float] = []
        if len(positive) < len(known) or not known:
            start = low - (high - low) * BAND_PART / (1 - BAND_PART)
            self.zero = 10 ** ((start + low) / 2)
            zeros = [self.zero]
            span = axes.axvspan if which == "x" else axes.axhspan
            span(10**start, 10**low, facecolor=BAND, edgecolor="none", zorder=0)
        axes.set(**{f"{which}scale": "log", f"{which}lim": (10**start, 10**high)})
        for ticks in tick_choices(low, high, positive if own else []):
            places = zeros + ticks
            names = [zero_name if t == self.zero else number(t) for t in places]
            if have_room(axes, which, places, names):
                set_ticks(axes, which, places, names)
                return
        set_ticks(axes, which, zeros, [zero_name] * len(zeros))

    def place(self, values: Iterable[float]) -> list[float]:
        """Where values are drawn."""
        return [v if v > 0 else self.zero if v == 0 else math.nan for v in values]


# Of ticks of a logarithmic axis: the first ones that have room.
TICK_DIGITS = ((1, 1.5, 2, 3, 4, 5, 6, 8), (1, 2, 3, 5), (1, 2, 5), (1, 3), (1,))


def tick_choices(low: float, high: float, own: Sequence[float]) -> Iterable[list[float]]:
    """Places of ticks between two powers of ten, given by their exponents; the finest first.

    `own`: the values themselves, which are the best ticks.
    """
    if own:
        yield sorted(set(own))
    exponents = range(math.floor(low), math.ceil(high) + 1)
    for digits in TICK_DIGITS:
        ticks = [d * 10.0**e for e in exponents for d in digits]
        yield (ticks := [t for t in ticks if low <= math.log10(t) <= high])
    for step in range(2, len(ticks)):
        yield ticks[::step]


def have_room(axes: Axes, which: str, places: Sequence[float], names: Sequence[str]) -> bool:
    """True if ticks of a logarithmic axis can have these names, none on another one."""
    low, high = axes.get_xlim() if which == "x" else axes.get_ylim()
    width, height = size_of(axes)
    scale = POINTS * (width if which == "x" else height) / math.log10(high / low)
    sizes = [
        len(n) * LETTER * FONT + TICK_GAP if which == "x" else LINE_HEIGHT * FONT for n in names
    ]
    gaps = [scale * math.log10(b / a) for a, b in itertools.pairwise(places)]
    return all(gap > (a + b) / 2 for gap, a, b in zip(gaps, sizes, sizes[1:]))


def set_ticks(axes: Axes, which: str, places: Sequence[float], names: Sequence[str]) -> None:
    """Ticks at places only, with names."""
    axis = axes.xaxis if which == "x" else axes.yaxis
    axis.set_major_locator(FixedLocator(places))
    axis.set_major_formatter(FuncFormatter(lambda _, i: names[i] if i is not None else ""))
    axis.set_minor_locator(NullLocator())


def new_figure(panels: int, width: float, height: float) -> tuple[Figure, list[Axes]]:
    """A figure with panels of one size, one above the other, that share x."""
    whole = panels * height + (panels - 1) * PANEL_GAP
    figure = Figure(figsize=(width, whole))
    FigureCanvasSVG(figure)
    made: list[Axes] = []
    for p in range(panels):
        bottom = whole - height - p * (height + PANEL_GAP)
        axes = figure.add_axes((0, bottom / whole, 1, height / whole))
        axes.set_axisbelow(True)
        axes.grid(True)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MaxNLocator(MOST_STEPS, steps=[1, 2, 2.5, 5, 10]))
            axis.set_major_formatter(NUMBERS)
        made.append(axes)
    return figure, made


def label(panels: Sequence[Axes], plot: dict[str, Any], ys: Sequence[str], beside: float) -> None:
    """Title and names of the axes; only the lowest panel says what x is.

    `beside`: how much room there is beside the axes for the title [inches].
    """
    title = wrapped(plot["title"], size_of(panels[0])[0] + beside, TITLE_FONT, BOLD_LETTER)
    panels[0].set_title(title, loc="left", pad=10)
    for axes, y in zip(panels, ys, strict=True):
        width, height = size_of(axes)
        axes.set_ylabel(wrapped(y, height), labelpad=8)
        axes.tick_params(axis="x", labelbottom=axes is panels[-1])
    panels[-1].set_xlabel(wrapped(plot["x"], width), labelpad=6)


def add_legend(axes: Axes, entries: Sequence[tuple[Line2D, str]], bold: Sequence[str] = ()) -> None:
    """A legend beside the axes."""
    legend = axes.legend(
        [handle for handle, _ in entries],
        ["-"] * len(entries),
        loc="upper left",
        bbox_to_anchor=(1.02, 1),
        borderaxespad=0,
        handlelength=2.8,
        labelspacing=0.6,
    )
    # A name that begins with "_" would have no entry, were it given above.
    for text, (_, name) in zip(legend.get_texts(), entries, strict=True):
        text.set_text(wrapped(name, LEGEND_WIDTH))
        if name in bold:
            text.set_fontweight("bold")


def look_of(line: dict[str, Any], column: str, place: int) -> tuple[Look, str]:
    """A line's look and its name in the legend."""
    key = line.get("look", "")
    turn = place % len(CYCLE)
    look = LOOKS[key] if key else Look(CYCLE[turn], CYCLE_MARKERS[turn], column)
    name = line.get("name") or look.name
    note = line.get("note", "")
    return look, f"{name}, {note}" if note else name


def draw_curves(plot: dict[str, Any]) -> Figure:
    """Lines over the first column, in one or more panels."""
    ys, columns = plot["y"], plot["columns"][1:]
    lines = plot["lines"] or [{} for _ in columns]
    height = AXES_HEIGHT if len(ys) == 1 else PANEL_HEIGHT
    figure, panels = new_figure(len(ys), AXES_WIDTH, height)
    label(panels, plot, ys, LEGEND_WIDTH)
    rows = plot["rows"]
    xs = [row[0] for row in rows]
    gap = math.ceil(len(xs) / MARKED)
    for p, axes in enumerate(panels):
        mine = [c for c, line in enumerate(lines) if line.get("panel", 0) == p]
        values = [row[c + 1] for row in rows for c in mine]
        x = LogAxis(axes, "x", xs, "0", own=True) if plot["log_x"] else None
        y = LogAxis(axes, "y", values, "none") if plot["log_y"] else None
        if y is None and not any(v < 0 for v in values):
            most = max((v for v in values if math.isfinite(v)), default=0.0)
            axes.set_ylim(0, 1.05 * most or 1.0)
        entries = []
        for i, c in enumerate(mine):
            look, name = look_of(lines[c], columns[c], c)
            stroke = lines[c].get("stroke", "solid")
            part = i / max(1, len(mine) - 1)
            style: dict[str, Any] = {
                "color": look.colour,
                "linestyle": DASHES[stroke],
                "linewidth": THICKEST + part * (THINNEST - THICKEST),
                "marker": "" if stroke == "bare" else look.marker,
                "markersize": LARGEST + part * (SMALLEST - LARGEST),
                "markerfacecolor": look.colour if look.ours else "none",
                "markeredgewidth": 1.2,
            }
            marked = 1 if len(xs) <= EACH_MARKED else (gap * i // len(mine), gap)
            line = [row[c + 1] for row in rows]
            at = x.place(xs) if x else xs
            axes.plot(at, y.place(line) if y else line, markevery=marked, **style)
            entries.append((Line2D([], [], **style), name))
        add_legend(axes, entries)
    return figure


def draw_map(plot: dict[str, Any]) -> Figure:
    """Values in cells. Along the axes are places, not values: these need not be evenly spaced."""
    rows = plot["rows"]
    xs, ys = sorted({row[0] for row in rows}), sorted({row[1] for row in rows})
    width, height = max(MAP_WIDTH, CELL_WIDTH * len(xs)), max(MAP_HEIGHT, CELL_HEIGHT * len(ys))
    figure, (axes,) = new_figure(1, width, height)
    label([axes], plot, [plot["y"]], 2 * BAR_WIDTH)
    cells = [[math.nan] * len(xs) for _ in ys]
    for x, y, value in rows:
        cells[ys.index(y)][xs.index(x)] = value
    most = max((row[2] for row in rows if math.isfinite(row[2])), default=0.0) or 1.0
    axes.grid(False)
    drawn = axes.pcolormesh(
        [*range(len(xs) + 1)],
        [*range(len(ys) + 1)],
        cells,
        cmap="cividis",
        vmin=0,
        vmax=most,
        edgecolors="face",
    )
    for j, line in enumerate(cells):
        for i, value in enumerate(line):
            # Cividis is dark below its middle.
            ink = "#ffffff" if value < 0.55 * most else "#000000"
            if math.isfinite(value):
                text = f"{value:.3g}"
                axes.text(i + 0.5, j + 0.5, text, color=ink, ha="center", va="center")
    set_ticks(axes, "x", [i + 0.5 for i in range(len(xs))], [number(x) for x in xs])
    set_ticks(axes, "y", [j + 0.5 for j in range(len(ys))], [number(y) for y in ys])
    axes.tick_params(length=0)
    bar_width = BAR_WIDTH / width
    beside = axes.inset_axes((1 + bar_width, 0, bar_width, 1))
    bar = figure.colorbar(drawn, cax=beside, format=NUMBERS)
    if bar.solids is not None:
        bar.solids.set_edgecolor("face")
    bar.set_label(wrapped(plot["value"], height), labelpad=8)
    bar.outline.set_visible(False)
    return figure


def draw_scatter(plot: dict[str, Any]) -> Figure:
    """Methods as points, over a logarithmic x, in panels that are logarithmic, too."""
    points = plot["points"]
    figure, panels = new_figure(len(plot["y"]), AXES_WIDTH, PANEL_HEIGHT)
    label(panels, plot, plot["y"], LEGEND_WIDTH)
    panels[0].set_title(panels[0].get_title(loc="left"), loc="left", pad=26)
    panels[0].annotate(
        wrapped(plot["corner"], AXES_WIDTH + LEGEND_WIDTH),
        (0, 1),
        xytext=(0, 8),
        xycoords="axes fraction",
        textcoords="offset points",
        color=PALE,
    )
    groups: dict[bool, list[tuple[Line2D, str]]] = {True: [], False: []}
    for p, axes in enumerate(panels):
        x = LogAxis(axes, "x", [point["x"] for point in points], "0")
        y = LogAxis(axes, "y", [point["y"][p] for point in points], "none")
        for point in points:
            look = LOOKS[point["look"]]
            large = point["stands_out"]
            style: dict[str, Any] = {
                "linestyle": "none",
                "marker": look.marker,
                "markersize": LARGE_POINT if large else POINT,
                "markerfacecolor": look.colour if look.ours else "none",
                "markeredgecolor": INK if look.ours else look.colour,
                "markeredgewidth": 0.7 if look.ours else 2.0,
            }
            at = x.place([point["x"]])
            axes.plot(at, y.place([point["y"][p]]), zorder=3, **style)
            if large:
                axes.axvline(at[0], color=look.colour, linestyle=DASHES["dashed"], linewidth=1.2)
            if p == 0:
                groups[look.ours].append((Line2D([], [], **style), look.name))
    entries = []
    titles = {True: "Pierce", False: "other libraries"}
    for ours, members in groups.items():
        if members:
            entries += [(Line2D([], [], linestyle="none"), titles[ours]), *members]
    add_legend(panels[0], entries, bold=list(titles.values()))
    return figure


KINDS = {"curves": draw_curves, "map": draw_map, "scatter": draw_scatter}


def draw(plot: dict[str, Any]) -> Figure:
    """A plot from its description."""
    matplotlib.rcdefaults()
    matplotlib.rcParams.update(SETTINGS)
    return KINDS[plot["kind"]](plot)


def cleaned(value: Any) -> Any:
    """A description in which null is NaN, which JSON has not, and texts have no control letters."""
    if isinstance(value, dict):
        return {key: cleaned(part) for key, part in value.items()}
    if isinstance(value, list):
        return [cleaned(part) for part in value]
    if isinstance(value, str):
        return "".join(c if c.isprintable() else " " for c in value)
    return math.nan if value is None else value


def style_sheet() -> str:
    """Rules that give things their twins' colours on a dark background."""
    rules = "".join(
        f'[style*="{what}: {light}"] {{ {what}: {dark} !important }}\n'
        for light, dark in DARK.items()
        for what in ("fill", "stroke")
    )
    return f"<style>\n@media (prefers-color-scheme: dark) {{\n{rules}}}\n</style>\n"


def write(figure: Figure, file: Path, title: str) -> None:
    """Writes a figure as SVG, the same bytes for the same figure; whole, or not at all."""
    part = file.with_name(f"{file.name}.part-{os.getpid()}")
    metadata = {"Title": title, "Date": None, "Creator": None}
    figure.savefig(part, format="svg", bbox_inches="tight", pad_inches=0.1, metadata=metadata)
    head, end, rest = part.read_text(encoding="utf-8").partition("<defs>")
    part.write_text(head + style_sheet() + end + rest, encoding="utf-8")
    part.replace(file)


def main() -> None:
    """Draws all plots that standard input describes."""
    # Letters that the measuring font has not are drawn with another one by whoever shows the plot.
    warnings.filterwarnings("ignore", message="Glyph")
    for plot in json.load(sys.stdin):
        known = cleaned(plot)
        write(draw(known), Path(plot["file"]), known["title"])


if __name__ == "__main__":
    main()
