"""What the study does not show, and what is missing in it."""
import html

from ratchet.page import Section

KNOWN = (
    "Rules that were set or changed after data had been seen: those for each disk (bounds, floor of the errors, smooth "
    "distribution, still to a hundredth of the rms, drives taken together), halves that last, second neighbours by sense, "
    "the least displacement of a jump, medians of the scans. That not each disk turns at 0.2 and 0.3 <i>g</i> came out "
    "under every version.",
    "Boxes hold 60 disks unless said otherwise, and are ten mean diameters wide: walls touch many of the disks. "
    "The runs with 10<sup>4</sup> disks are single packings, their numbers have no error from packings.",
    "Openings are counted each time: a contact that chatters opens several times in a period, and those of rattlers count "
    "in the means over all contacts.",
    "A disk that stands still does so within the limit and the time given there: a slower rotation is not seen, and a "
    "rearrangement later may set it turning.",
    "Rattlers are told by the contacts at some hundred moments of the measured time; a disk that is caged for half of it "
    "counts as caged.",
    "Each drive of a sweep has packings of its own: the scatter of packings is in every curve.",
    "The heap is 60 mean diameters wide and poured from just above its top, which flattens it there; the drum is one "
    "run.",
    "The time step study has the same seeds at each step, but each run deposits its own packing: its points scatter.",
)


def section(found):
    """found: all other sections."""
    out = Section("limits", "Limits")
    parts = ["<ul>" + "".join(f"<li>{text}</li>" for text in KNOWN) + "</ul>"]
    missing = list(dict.fromkeys(line for part in found for line in part.missing))
    if missing:
        parts.append("<p><b>Not run, or not finished</b>: " + html.escape("; ".join(missing)) + ".</p>")
    out.lead = "".join(parts)
    return out
