"""Times that can be compared: a repeat of everybody, then the next of everybody; a slow spell falls on all alike."""
import dataclasses
import os
import platform
import re
import time

import numpy as np


@dataclasses.dataclass
class Times:
    """Of one contestant, in the order of the repeats."""
    values: list

    @property
    def median(self):
        return float(np.median(self.values))

    @property
    def least(self):
        return float(min(self.values))

    @property
    def spread(self):
        """Distance of the quartiles over the median."""
        low, high = np.percentile(self.values, (25, 75))
        return float((high - low) / self.median)


def ratio(times, reference):
    """(median, least, largest) of the quotients of neighbouring repeats."""
    quotients = np.array(times.values) / np.array(reference.values)
    return float(np.median(quotients)), float(quotients.min()), float(quotients.max())


def alternate(contestants, repeats, say=lambda text: None):
    """contestants: {name: function that runs once and returns a time}. Who goes first changes with every repeat."""
    found = {name: [] for name in contestants}
    for repeat in range(repeats):
        for name in list(contestants) if repeat % 2 == 0 else reversed(contestants):
            found[name].append(contestants[name]())
            say(f"repeat {repeat + 1} of {repeats}: {name} {found[name][-1]:.4g}")
    return {name: Times(values) for name, values in found.items()}


def machine():
    """What the numbers depend on besides the programs."""
    try:
        with open("/proc/cpuinfo") as file:
            model = re.search(r"model name\s*: (.*)", file.read()).group(1)
    except (OSError, AttributeError):
        model = platform.machine()
    return f"{model}, {os.cpu_count()} cores, {time.strftime('%Y-%m-%d', time.gmtime())}"


def load():
    """How many processes wanted to run in the last minute, without us: ask before anything is started."""
    return os.getloadavg()[0]
