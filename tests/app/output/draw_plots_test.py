"""Plots are legible: no text is on another one, and no two things look the same.

Imports draw_plots.py from PYTHONPATH.
"""

import itertools
import math
import unittest
from typing import Any

import draw_plots
from draw_plots import LogAxis, draw
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from plot_looks import DARK, LOOKS

LONG = "a name of which nobody thought that it would ever be as long as this one is"


def texts_of(axes: Axes) -> list[Text]:
    """All texts that are drawn."""
    found: list[Text] = [axes.xaxis.label, axes.yaxis.label, *axes.texts]
    found += [t for t in axes.get_children() if isinstance(t, Text)]
    for axis in (axes.xaxis, axes.yaxis):
        low, high = sorted(axis.get_view_interval())
        found += [t.label1 for t in axis.get_major_ticks() if low <= t.get_loc() <= high]
        found += [t.label2 for t in axis.get_major_ticks() if low <= t.get_loc() <= high]
    legend = axes.get_legend()
    if legend is not None:
        found += legend.get_texts()
    return [t for t in dict.fromkeys(found) if t.get_visible() and t.get_text().strip()]


def curves(count: int, rows: list[list[float]], **more: Any) -> dict[str, Any]:
    """A description of curves with long names."""
    return {
        "kind": "curves",
        "title": LONG,
        "x": LONG,
        "y": ["share [%]"],
        "log_x": False,
        "log_y": False,
        "columns": ["x", *(f"{LONG} {i}" for i in range(count))],
        "rows": rows,
        "lines": [],
        **more,
    }


def scatter(points: list[dict[str, Any]]) -> dict[str, Any]:
    """A description of points."""
    return {
        "kind": "scatter",
        "title": LONG,
        "x": "time [ms]",
        "y": ["pairs missed [%]", LONG],
        "corner": LONG,
        "points": points,
    }


def heat_map(size: int, scale: float) -> dict[str, Any]:
    """A description of a map."""
    cells = itertools.product(range(size), range(size))
    return {
        "kind": "map",
        "title": LONG,
        "x": LONG,
        "y": LONG,
        "value": LONG,
        "rows": [[2.0**i, 0.125 * j, scale * i * j] for j, i in cells],
    }


class DrawPlotsTest(unittest.TestCase):
    """What draw_plots.py draws."""

    def expect_legible(self, figure: Figure) -> None:
        """No two texts share a place, and no legend is on a panel."""
        canvas = FigureCanvasAgg(figure)
        canvas.draw()  # type: ignore[no-untyped-call]
        renderer = canvas.get_renderer()  # type: ignore[no-untyped-call]
        panels: list[Any] = [*figure.axes, *(a for axes in figure.axes for a in axes.child_axes)]
        texts = [t for axes in panels for t in texts_of(axes)]
        boxes = [t.get_window_extent(renderer) for t in texts]
        self.assertGreater(len(texts), 5)
        for (a, box_a), (b, box_b) in itertools.combinations(zip(texts, boxes), 2):
            self.assertFalse(box_a.overlaps(box_b), f"{a.get_text()!r} on {b.get_text()!r}")
        legends = [legend for axes in figure.axes if (legend := axes.get_legend()) is not None]
        for legend, panel in itertools.product(legends, figure.axes):
            box = panel.get_window_extent(renderer)
            self.assertFalse(legend.get_window_extent(renderer).overlaps(box))

    def test_curves_are_legible(self) -> None:
        """Whatever numbers and names there are."""
        for count, low, step in itertools.product((1, 2, 9), (1e-7, 0.2, 3e5), (1.01, 2, 100)):
            rows = [[i * low] + [low * step ** (i + c) for c in range(count)] for i in range(8)]
            rows[3][-1] = 0
            for log_x, log_y in itertools.product((False, True), repeat=2):
                with self.subTest(count=count, low=low, step=step, log_x=log_x, log_y=log_y):
                    self.expect_legible(draw(curves(count, rows, log_x=log_x, log_y=log_y)))

    def test_panels_are_legible(self) -> None:
        """Panels one above the other, with legends of their own."""
        lines = [{"panel": p} for p in (0, 0, 1, 2)]
        rows = [[x, 10.0 * x, x, x / 1000, x * 1e6] for x in range(20)]
        for log_y in (False, True):
            plot = curves(4, rows, y=["a [%]", "b [ms]", "c"], lines=lines, log_y=log_y)
            self.expect_legible(draw(plot))

    def test_scatters_are_legible(self) -> None:
        """All methods there are, in the same place and far apart."""
        for spread in (0, 0.01, 3):
            points = [
                {
                    "look": look,
                    "x": 10 ** (spread * math.sin(i)),
                    "y": [max(0, math.sin(2 * i)), 10 ** (spread * math.cos(i))],
                    "stands_out": i == 4,
                }
                for i, look in enumerate(LOOKS)
            ]
            with self.subTest(spread=spread):
                self.expect_legible(draw(scatter(points)))

    def test_maps_are_legible(self) -> None:
        """Numbers fit into their cells."""
        for size, scale in itertools.product((2, 6), (0, 1e-5, 1, 12345.678)):
            with self.subTest(size=size, scale=scale):
                self.expect_legible(draw(heat_map(size, scale)))

    def test_odd_numbers_are_drawn(self) -> None:
        """No rows, one row, nothing but zeros, what is no number."""
        for rows in ([], [[0.0, 0.0]], [[1.0, math.nan], [2.0, 3.0]], [[1.0, -2.0], [2.0, 3.0]]):
            for log in (False, True):
                with self.subTest(rows=rows, log=log):
                    self.expect_legible(draw(curves(1, rows, log_x=log, log_y=log)))

    def test_zeros_stand_below_all_others(self) -> None:
        """Zeros of a logarithmic axis have a place of their own, which says so."""
        axes = Figure().add_subplot()
        axis = LogAxis(axes, "y", [0.0, 1e-3, 5.0], "none")
        zero, least, most = axis.place([0.0, 1e-3, 5.0])
        self.assertLess(zero, least)
        self.assertEqual((least, most), (1e-3, 5.0))
        names = dict(zip(axes.get_yticks(), (t.get_text() for t in axes.get_yticklabels())))
        self.assertEqual(names[zero], "none")
        self.assertTrue(math.isnan(LogAxis(axes, "y", [1.0, 5.0], "none").zero))

    def test_nothing_looks_like_another_thing(self) -> None:
        """Colour, marker and whose it is are not those of another method."""
        looks = [(look.colour, look.marker, look.ours) for look in LOOKS.values()]
        self.assertEqual(len(set(looks)), len(looks))
        names = [look.name for look in LOOKS.values()]
        self.assertEqual(len(set(names)), len(names))

    def test_a_method_has_its_look(self) -> None:
        """The same in every kind of plot."""
        rows = [[1.0, 1.0], [2.0, 2.0]]
        for key, look in LOOKS.items():
            line = draw(curves(1, rows, lines=[{"look": key}])).axes[0].lines[0]
            self.assertEqual((line.get_color(), line.get_marker()), (look.colour, look.marker))
            points = [{"look": key, "x": 1.0, "y": [1.0, 1.0], "stands_out": False}]
            (point,) = draw(scatter(points)).axes[0].lines
            shown = point.get_markerfacecolor() if look.ours else point.get_markeredgecolor()
            self.assertEqual((shown, point.get_marker()), (look.colour, look.marker))
        with self.assertRaises(KeyError):
            draw(curves(1, rows, lines=[{"look": "sat"}]))

    def test_what_changes_in_the_dark_is_found(self) -> None:
        """The style sheet knows every colour that is no data."""
        for light, dark in DARK.items():
            self.assertIn(f'[style*="fill: {light}"] {{ fill: {dark} ', draw_plots.style_sheet())


if __name__ == "__main__":
    unittest.main()
