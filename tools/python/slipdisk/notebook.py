"""What notebooks show: tables of objects, the page of `slipdisk view`, progress of long calls."""
from __future__ import annotations

import html
import os
import sys
import tempfile
import time as clock

from .arguments import Fixed, checked
from .library import StrPath, UserError, Whole, whole
from .process import call

DELAY = 1.0  # s: shorter calls show no progress
LARGEST_PAGE = 64e6  # bytes of a page that a notebook takes
ROWS, WIDTH = 20, 10  # rows and columns of a table that are shown


# --- tables -----------------------------------------------------------------------------------------------------------
def cell(value):
    """A value as it stands in a table."""
    if isinstance(value, float):
        return f"{value:.6g}"
    return str(value)


def table_html(head, rows, numeric=()):
    """An HTML table; the columns of these numbers are set flush right."""
    def line(tag, cells):
        style = ["right" if k in numeric else "left" for k in range(len(cells))]
        return "<tr>" + "".join(f'<{tag} style="text-align:{style[k]}">{html.escape(cell(value))}</{tag}>'
                                for k, value in enumerate(cells)) + "</tr>"
    return "<table>" + (f"<thead>{line('th', head)}</thead>" if head else "") + "".join(line("td", row) for row in rows) + "</table>"


def array_html(array, rows=ROWS, width=WIDTH):
    """The beginning of a structured array as an HTML table."""
    names = list(array.dtype.names)[:width]
    shown = table_html(names, [[row[name].item() if array.dtype[name].shape == () else row[name].tolist() for name in names]
                               for row in array[:rows]], [k for k, name in enumerate(names) if array.dtype[name].kind in "iuf"])
    more = [f"{len(array)} rows"] * (len(array) > rows) + [f"{len(array.dtype.names)} columns"] * (len(array.dtype.names) > width)
    return shown + (f"<p>the first of {', '.join(more)}</p>" if more else "")


class Shown:
    """Objects that a notebook shows as a caption, which is their repr, and tables: `_tables()` gives their HTML."""

    def _repr_html_(self):
        return f"<p><b>{html.escape(repr(self))}</b></p>" + "".join(self._tables())


# --- slipdisk view ----------------------------------------------------------------------------------------------------
class View(Fixed):
    """The page of `slipdisk view`, which a notebook shows in place; it needs no network. `page` is its text; `save(path)` writes it,
    for any browser."""

    page: str
    height: int

    @checked
    def __init__(self, page: str, height: Whole) -> None:
        self._set(page=page, height=whole(height, "view: height", 100, 10_000))

    @checked
    def save(self, path: StrPath) -> None:
        """Writes the page into a file."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.page)

    def _repr_html_(self):
        return (f'<iframe srcdoc="{html.escape(self.page)}" width="100%" height="{self.height}" style="border:0" '
                'title="slipdisk view" allowfullscreen></iframe>')

    def __repr__(self):
        return f"<slipdisk view: a page of {len(self.page) / 1e6:.3g} MB; a notebook shows it, save(path) writes it>"


def view(path: str, frames: str | None, height: Whole, cwd: str | None = None) -> View:
    """The View of a result or checkpoint; a relative path is one from the folder cwd."""
    with tempfile.TemporaryDirectory(prefix="slipdisk-") as folder:
        page = os.path.join(folder, "page.html")
        call("view", path, "-o", page, *([f"--frames={frames}"] if frames is not None else []), cwd=cwd)
        size = os.path.getsize(page)
        if size > LARGEST_PAGE:
            raise UserError(f"view: the page has {size / 1e6:.3g} MB, a notebook takes {LARGEST_PAGE / 1e6:g} MB: take fewer frames, as in "
                            f"view(frames=\"::10\"); slipdisk view {path} makes a file")
        with open(page, encoding="utf-8") as file:
            return View(file.read(), height)


# --- progress ---------------------------------------------------------------------------------------------------------
def in_notebook():
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return hasattr(shell, "kernel")


def on_screen():
    """True in a notebook, and if standard error is a terminal."""
    return in_notebook() or (sys.stderr is not None and sys.stderr.isatty())


class Line:
    """The part of tqdm's bar that is used here, as a line of text."""

    def __init__(self, total, initial, desc, leave, **_):
        self.n, self.total, self._desc, self._leave, self._first, self.start_t = initial, total, desc, leave, initial, clock.time()
        self._told, self._width = 0.0, 0

    def update(self, more):
        self.n += more
        now = clock.time()
        if now - self._told < 0.5 and self.n < self.total:
            return
        self._told = now
        text = f"{self._desc}: {100 * self.n / self.total:.0f} %"
        if self.n > self._first:
            text += f", {(now - self.start_t) * (self.total - self.n) / (self.n - self._first):.0f} s left"
        sys.stderr.write("\r" + text.ljust(self._width))
        sys.stderr.flush()
        self._width = len(text)

    def close(self):
        sys.stderr.write("\n" if self._leave else "\r" + " " * self._width + "\r")


def bar(**arguments):
    """A bar of tqdm, with widgets where a notebook has them; a Line without tqdm. It stays in a notebook, and goes on a terminal."""
    arguments["leave"] = in_notebook()
    try:
        import warnings
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # without ipywidgets it is one of text
            from tqdm.auto import tqdm
    except ImportError:
        return Line(**arguments)
    return tqdm(**arguments, unit_scale=True, smoothing=0)


class Progress:
    """Shows how far a call is, once it has taken a second. wanted: True, False, or None: on_screen()."""

    def __init__(self, desc, unit, wanted=None):
        self.wanted = on_screen() if wanted is None else bool(wanted)
        self._words = {"desc": desc, "unit": unit}
        self._bar, self._first = None, None

    def at(self, done, total):
        """So much of the total is done; nothing is shown while the total is 0."""
        if self._bar is None:
            if not self.wanted or not total:
                return
            self._first = self._first or (clock.time(), done)
            waited = clock.time() - self._first[0]
            if waited < DELAY:
                return
            self._bar = bar(**self._words, total=total, initial=self._first[1])
            self._bar.start_t -= waited  # the rate is that since the beginning
        self._bar.total = total
        self._bar.update(done - self._bar.n)

    def close(self):
        if self._bar is not None:
            self._bar.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
