"""How things look in plots: colours, markers, names and fonts, each said once."""

from typing import Any, NamedTuple

# Colours of what is no data, and of the darkest data, each with its twin on a dark background. No
# other thing has one of these colours: the style sheet finds them by their values.
INK, PALE, GRID, BAND = "#1f2328", "#626a73", "#d4d8dd", "#f0f1f3"
DARK = {INK: "#e6edf3", PALE: "#9aa4af", GRID: "#3a4149", BAND: "#1d2229"}

# Told apart with any kind of colour vision: M. Okabe and K. Ito, Color Universal Design, 2002.
# Their yellow is left out: it is too pale for a line on white.
ORANGE, SKY, GREEN, BLUE = "#e69f00", "#56b4e9", "#009e73", "#0072b2"
VERMILION, PURPLE = "#d55e00", "#cc79a7"
CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, INK)
CYCLE_MARKERS = "osD^vXP"


class Look(NamedTuple):
    """How a method, or another thing that is compared, looks in every plot."""

    colour: str
    marker: str  # empty: none
    name: str
    ours: bool = True  # false: of another library; its marker is hollow


LOOKS = {
    # Methods for solids.
    "full": Look(INK, "o", "full: all rays anew"),
    "walk": Look(ORANGE, "^", "walk: iterative rays"),
    "walk-predict": Look(BLUE, "v", "walk-predict: iterative and predictive rays"),
    "certified": Look(SKY, "D", "certified: only rays that are needed"),
    "overlaps": Look(VERMILION, "*", "overlaps (default)"),
    "complete": Look(GREEN, "s", "complete: all edges, too"),
    "reprojected": Look(PURPLE, "P", "reprojected: complete and re-projected"),
    "gjk-hull": Look(SKY, "s", "gjk-hull: Bullet, convex hulls", ours=False),
    "gjk-epa": Look(BLUE, "D", "gjk-epa: Bullet, convex pieces", ours=False),
    "gimpact": Look(ORANGE, "h", "gimpact: Bullet, triangles", ours=False),
    "fcl": Look(PALE, "o", "fcl: triangles", ours=False),
    # Methods for sheets.
    "continuous": Look(VERMILION, "s", "continuous (default)"),
    "rays": Look(ORANGE, "D", "rays: relative velocity"),
    "published": Look(PURPLE, "X", "published: absolute velocity"),
    "bullet-clusters": Look(BLUE, "v", "bullet-clusters", ours=False),
    # Tests of a ray and a triangle.
    "moeller_trumbore": Look(ORANGE, "p", "Möller and Trumbore"),
    "pluecker": Look(SKY, "X", "Plücker"),
    "watertight": Look(BLUE, "^", "watertight"),
    "watertight_double": Look(PURPLE, "d", "watertight in double"),
    "pierce": Look(VERMILION, "P", "Pierce"),
    # What they are compared with.
    "truth": Look(GREEN, "x", "truth"),
    "paper": Look(PALE, "", "the paper"),
    # Numbers of one thing.
    "mean": Look(BLUE, "o", "mean"),
    "maximum": Look(VERMILION, "^", "maximum"),
    "standard deviation": Look(GREEN, "D", "standard deviation"),
}

DASHES: dict[str, Any] = {
    "solid": "-",
    "dashed": (0, (4, 2)),
    "dotted": (0, (1, 1.5)),
    "bare": "-",  # without markers
    "points": "none",  # markers alone
}

FONT, TITLE_FONT = 9.5, 11.5  # [points]
# Of matplotlib.
SETTINGS: Any = {
    "font.family": "sans-serif",
    # The first one comes with matplotlib and is as wide as any: what is measured with it has room
    # with all others.
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial", "Helvetica", "sans-serif"],
    "font.size": FONT,
    "text.color": INK,
    "text.parse_math": False,
    "axes.titlesize": TITLE_FONT,
    "axes.titleweight": "bold",
    "axes.facecolor": "none",
    "axes.edgecolor": PALE,
    "axes.labelcolor": INK,
    "axes.formatter.useoffset": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": PALE,
    "ytick.color": PALE,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "legend.frameon": False,
    "legend.fontsize": FONT,
    "figure.facecolor": "none",
    "svg.fonttype": "none",
    "svg.hashsalt": "pierce",
}
