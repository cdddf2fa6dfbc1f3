"""What the study does not show, and what is missing in it."""
import html

from report.page import Section
from report.verdict import NO, OPEN

KNOWN = (
    "All boxes hold 60 disks and are ten mean diameters wide: walls touch a good part of the disks. The runs with "
    "10<sup>4</sup> disks are single packings, their numbers have no error from packings.",
    "Openings are counted each time: a contact that chatters opens several times in a period. A few loose disks at the "
    "surface open contacts at any drive, so there is no drive below which the count is zero.",
    "At low drive most disks at the bottom stick and do not turn at all: the median of |&Omega;| then says little, and "
    "correlations rest on the disks that do.",
    "The heap is 60 mean diameters wide and poured from just above its top, which flattens it there; the drum is one "
    "run.",
    "The time step study has the same seeds at each step, but each run deposits its own packing: its points scatter.",
)


def section(found):
    """found: all other sections."""
    out = Section("limits", "Limits, and what was not met")
    parts = ["<br>".join(f"&bull; {text}" for text in KNOWN)]
    for word, title in ((NO, "Not met"), (OPEN, "Cannot be told")):
        texts = [claim.text for part in found for claim in part.claims if claim.verdict == word]
        if texts:
            parts.append(f"<b>{title}</b>: " + " ".join(texts))
    missing = list(dict.fromkeys(line for part in found for line in part.missing))
    if missing:
        parts.append("<b>Not run, or not finished</b>: " + html.escape("; ".join(missing)) + ".")
    out.lead = "<br><br>".join(parts)
    return out
