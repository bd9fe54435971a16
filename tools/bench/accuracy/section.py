"""One part of the report: markdown with figures, and the gates it met or missed."""

import json
import pathlib
from dataclasses import dataclass, field

from . import REPOSITORY

PICTURES = REPOSITORY / "docs" / "pictures" / "accuracy"
PLOT_SIZE = (6.4, 3.6)


@dataclass
class Section:
    text: str = ""
    gates: list = field(default_factory=list)

    def say(self, *lines):
        self.text += "\n".join(lines) + "\n\n"

    def table(self, header, rows):
        lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
        lines += ["| " + " | ".join(_cell(c) for c in row) + " |" for row in rows]
        self.say(*lines)

    def gate(self, what, value, limit, unit=""):
        """Remembers a bound that must hold: value < limit."""
        self.gates.append({"what": what, "value": float(value), "limit": float(limit), "unit": unit})

    def plot(self, name, draw, caption):
        """draw(figure, axes) makes one figure; it goes to docs/pictures/accuracy/NAME.png."""
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot

        figure, axes = pyplot.subplots(figsize=PLOT_SIZE, dpi=110, layout="constrained")
        axes.grid(True, which="both", alpha=0.25)
        draw(figure, axes)
        PICTURES.mkdir(parents=True, exist_ok=True)
        figure.savefig(PICTURES / f"{name}.png", metadata={"Software": None})
        pyplot.close(figure)
        self.say(f"![{caption}](pictures/accuracy/{name}.png)", "", f"*{caption}*")

    def save(self, path: pathlib.Path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({"text": self.text, "gates": self.gates}))

    @staticmethod
    def read(path: pathlib.Path):
        return Section(**json.loads(path.read_text()))


def _cell(value):
    if isinstance(value, float):
        return f"{value:.3g}" if abs(value) < 0.1 or abs(value) >= 1000 else f"{value:.2f}" if abs(value) < 100 else f"{value:.0f}"
    return str(value)
