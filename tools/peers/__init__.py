"""slipdisk beside LAMMPS and LIGGGHTS: see tools/compare_peers.sh.

    packing.py    the packing: made by slipdisk, repeated along x, written as each program wants it
    inputs.py     input texts of LAMMPS and LIGGGHTS, decks of slipdisk: the one place that knows how parameters match
    programs.py   where the programs are; a run of each, bound to its cores; what they print
    frames.py     frames of each program, and what is compared of them
    timing.py     repeats in alternation, medians and spreads
    bench.py      packings: agreement and time
    bonds.py      a bonded sheet that is torn, beside the newest LAMMPS
    three.py      one disk on two supports: agreement and time
    accuracy.py   loops and restarts
    laws.py       each contact law of LAMMPS in keys of slipdisk
    law_runs.py   collisions, rolling and a packing with each law
    law_page.py   their tables
    page.py       Markdown
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "python"))
