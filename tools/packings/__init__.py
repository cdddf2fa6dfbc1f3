"""The study of packings, run and drawn: see tools/packings.sh. Figures, verdicts and pages look as in tools/report."""
