"""The study of packings, run and drawn: see tools/studies/packings.sh.

Figures, verdicts and pages look as in tools/studies/ratchet."""
