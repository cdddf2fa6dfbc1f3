"""Trials that try to make slipdisk lose or falsify a result; see tools/soak.sh and docs/reliability.md."""
