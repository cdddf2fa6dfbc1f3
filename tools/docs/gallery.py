#!/usr/bin/env python3
"""Makes the pictures of docs/gallery.md by the commands that stand there:

    tools/docs/gallery.py [PROGRAM [NAME ...]]     PROGRAM: build/release/slipdisk; NAME: only pictures of this name

Results go to results/gallery, and stay: a run that is finished is not run again. Pictures go to docs/figures/gallery.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BLOCK = re.compile(r"^!\[.*?\]\(figures/gallery/(\S+)\)\n\n```sh\n(.*?)^```", re.M | re.S)


def main():
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__)
        return
    program = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/slipdisk").resolve()
    wanted = sys.argv[2:]
    work, pictures = ROOT / "results/gallery", ROOT / "docs/figures/gallery"
    for folder in (work, pictures):
        folder.mkdir(parents=True, exist_ok=True)
    if not (work / "inputs").exists():
        (work / "inputs").symlink_to(ROOT / "inputs")
    environment = {**os.environ, "PATH": f"{program.parent}:{os.environ['PATH']}"}
    for name, commands in BLOCK.findall((ROOT / "docs/gallery.md").read_text()):
        if wanted and name.split(".")[0] not in wanted:
            continue
        for command in commands.splitlines():
            made = re.search(r" -o (\S+\.(?:h5|sweep))", command)
            if made and (work / made[1]).exists():
                continue
            print(command, flush=True)
            subprocess.run(["bash", "-c", command], cwd=work, env=environment, check=True, stdout=subprocess.DEVNULL)
        shutil.copy(work / name, pictures / name)
        print(f"{name}: {(work / name).stat().st_size} bytes", flush=True)


if __name__ == "__main__":
    main()
