#!/usr/bin/env bash
# Tags the last commit with the version of include/slipdisk/version.h: v0.6.0. Before that: a new version and day there, in
# docs/changelog.md, CITATION.cff and codemeta.json, which tests/docs/test_version.py compares; commit; all tests.
#   tools/packaging/tag.sh            makes the tag; git push origin vVERSION publishes it
set -euo pipefail
case "${1:-}" in
  "") ;;
  -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
  *) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac
cd "$(dirname "$0")/../.."
if [ -n "$(git status --porcelain)" ]; then echo "There are changes that are not committed." >&2; exit 1; fi
/usr/bin/python3 tests/docs/test_version.py
version=$(sed -n 's/^#define SD_VERSION "\(.*\)".*/\1/p' include/slipdisk/version.h)
git tag -a "v$version" -m "slipdisk $version"
echo "tag     v$version"
