"""lint.py BUILD TIDY: clang-tidy over src/ with the compile commands of BUILD. Called by tools/style.sh lint.

Nearly all its time goes into the static analyser, so a file is looked at again only when its text as the compiler
sees it has changed, the checks, or clang-tidy; BUILD/lint keeps what was found in order. The analyser follows 75000
states of a function, which takes a third of the time of its own limit of 225000 (SLIPDISK_LINT_STATES).
"""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
STATES = int(os.environ.get("SLIPDISK_LINT_STATES", 75000))
OPTIONS = ["--quiet", "--extra-arg=-Wno-unknown-warning-option", "--extra-arg=-Xclang",
           "--extra-arg=-analyzer-config", "--extra-arg=-Xclang", f"--extra-arg=max-nodes={STATES}"]


def files(build):
    """file -> (folder, compile command); a kernel is compiled several times, the first counts"""
    found = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        path = pathlib.Path(entry["file"])
        if path.is_relative_to(ROOT / "src"):
            found.setdefault(path, (entry["directory"], shlex.split(entry["command"])))
    return found


def key(path, folder, command, rules):
    """Of the preprocessed text, of the text itself (it may silence a check), and of the rules."""
    words = command[:command.index("-o")] + ["-E", "-o", "-", str(path)]
    text = subprocess.run(words, cwd=folder, check=True, capture_output=True).stdout
    return hashlib.sha256(rules + path.read_bytes() + text).hexdigest()


def lint(path, folder, command, rules, tidy, build):
    mark = build / "lint" / key(path, folder, command, rules)
    if mark.exists():
        return "known"
    done = subprocess.run([tidy, "-p", build, *OPTIONS, path], capture_output=True, text=True)
    if done.returncode == 0:
        mark.touch()
        return "sound"
    said = [line for line in done.stderr.splitlines() if not line.endswith(" generated.") and "treated as" not in line]
    print(done.stdout + "\n".join(said), file=sys.stderr, flush=True)
    return "finding"


def main():
    build, tidy = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
    (build / "lint").mkdir(exist_ok=True)
    version = subprocess.run([tidy, "--version"], check=True, capture_output=True).stdout
    rules = version + (ROOT / ".clang-tidy").read_bytes() + " ".join(OPTIONS).encode()
    work = files(build)
    missing = set((ROOT / "src").rglob("*.c")) - set(work)
    if missing:
        sys.exit(f"no compile command of {', '.join(sorted(map(str, missing)))}: configure again")
    # the largest first: the analyser needs longest for them
    order = sorted(work, key=lambda path: -path.stat().st_size)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        said = list(pool.map(lambda path: lint(path, *work[path], rules, tidy, build), order))
    if "finding" in said:
        return 1
    print(f"Lint: {len(said)} files without a finding, {said.count('known')} of them as they were before.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
