"""The study of packings, run and drawn: see tools/packings.sh. Look of figures, verdicts and pages are those of tools/report."""
