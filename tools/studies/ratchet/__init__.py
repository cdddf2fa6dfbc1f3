"""The report of tools/studies/ratchet.sh: runs the decks of inputs/paper and draws the paper's figures.

    levels.py    what is run at which length: the one table to change
    runs.py      calls of the program: runs, sweeps, theory curves
    data.py      their results as tables; what is missing
    fits.py      extremum, crossing, and tests of significance
    verdict.py   claims, and how data decide about them
    style.py     one look for all figures
    effort.py    time of all calls, and the machine
    page.py      one self-contained HTML page
    errors.py    the study of --errors: how far time step and noise interval can be raised
    the others   one module per group of figures; each has sections(results) -> list of page.Section
"""
