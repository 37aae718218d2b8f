"""The page of `quoin view` in a notebook: simulations, scenes and folders of runs."""
import csv
import html
import json
import pathlib
import shutil
import tempfile
import weakref

from . import _quoin
from .scenes import Scene


class Page:
    """A page of one file that opens without a network: shown by notebooks, written by save()."""

    def __init__(self, text):
        self.text = text

    def save(self, path):
        """Writes the HTML file."""
        pathlib.Path(path).write_text(self.text, encoding="utf-8")

    def _repr_html_(self):
        return f'<iframe srcdoc="{html.escape(self.text)}" width="100%" height="600" frameborder="0"></iframe>'


class Recording:
    """Frames of a Simulation; call it to take one more.

    recording = Recording(simulation)
    simulation.run(until=1.0, callback=recording)    # after each step; `every` step takes a frame
    recording                                        # in a notebook: the page
    """

    def __init__(self, simulation, *, every=1, title="quoin"):
        if every < 1:
            raise _quoin.InputError(f"every: {every}, at least 1")
        self._simulation, self._every, self._title, self._calls = simulation, every, title, 0
        self._folder = pathlib.Path(tempfile.mkdtemp(prefix="quoin-"))
        weakref.finalize(self, shutil.rmtree, self._folder, ignore_errors=True)
        self._frames, self._history = [], []
        self._take()

    def __call__(self):
        self._calls += 1
        if self._calls % self._every == 0:
            self._take()

    def __len__(self):
        return len(self._frames)

    def _take(self):
        number, folder = len(self._frames), self._folder
        self._simulation.to_vtk(str(folder / f"blocks_{number}.vtu"), str(folder / f"contacts_{number}.vtp"))
        self._frames.append(self._simulation.time)
        self._history.append({"time": self._simulation.time, **self._simulation.energy})

    def page(self):
        """The Page of all frames so far."""
        folder = self._folder
        for name, ending in (("blocks", "vtu"), ("contacts", "vtp")):
            files = "".join(f'<DataSet timestep="{time!r}" file="{name}_{number}.{ending}"/>'
                            for number, time in enumerate(self._frames))
            (folder / f"{name}.pvd").write_text(f"<VTKFile><Collection>{files}</Collection></VTKFile>")
        with open(folder / "history.csv", "w", newline="", encoding="utf-8") as file:
            table = csv.DictWriter(file, list(self._history[0]))
            table.writeheader()
            table.writerows(self._history)
        (folder / "blocks.csv").write_text("stage,time\n", encoding="utf-8")
        summary = {"title": self._title, "flags": [], "failures": [], "stages": []}
        (folder / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
        return _page_of_folder(folder)

    def save(self, path):
        """Writes the page."""
        self.page().save(path)

    def _repr_html_(self):
        return self.page()._repr_html_()


def _page_of_folder(folder):
    from ._tools import view as tool
    with tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name) / "page.html"
        try:
            tool.run_page(folder, out)
        except SystemExit as refusal:  # of the command
            raise _quoin.InputError(str(refusal)) from None
        return Page(out.read_text(encoding="utf-8"))


def view(shown):
    """The Page of a Simulation as it stands, of a Scene at its start, or of a folder that `quoin run --out` left."""
    if isinstance(shown, Scene):
        title = str(shown.get("title", "quoin"))
        return Recording(_quoin.Simulation(shown), title=title).page()
    if isinstance(shown, _quoin.Simulation):
        return Recording(shown).page()
    return _page_of_folder(pathlib.Path(shown))
