"""docs/python.md, docs/coming_from_python.md: every block of Python is run, in order, and prints what the block below it shows.

    tests/docs/test_python_tutorial.py --write    puts in what is printed now
"""
import contextlib
import io
import os
import pathlib
import re
import sys
import tempfile
import traceback
import warnings

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
BUILD = pathlib.Path(os.environ.get("SLIPDISK_BUILD_DIR", ROOT / "build/release"))
PAGES = ROOT / "docs/python.md", ROOT / "docs/coming_from_python.md"
LIBRARY = BUILD / "libslipdisk.so"
BLOCK = re.compile(r"```python\n(?P<code>.*?)```\n(?:\n```text\n(?P<shown>.*?)```\n)?", re.DOTALL)


def printed(page, code, line, space):
    """What a block prints; an error that it ends with is printed as its last line, as Python does."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        try:
            exec(compile("\n" * line + code, str(page), "exec"), space)
        except Exception as error:
            if "# fails" not in code:
                raise
            out.write("".join(traceback.format_exception_only(error)))
    return out.getvalue()


def follow(page, write):
    """Runs the blocks of a page; returns how many print something else."""
    text, space, made, wrong = page.read_text(encoding="utf-8"), {}, [], 0
    end = 0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        os.symlink(ROOT / "inputs", "inputs")
        for block in BLOCK.finditer(text):
            line = text[:block.start()].count("\n") + 1
            out = printed(page, block["code"], line, space)
            made.append(text[end:block.start()] + f"```python\n{block['code']}```\n" + (f"\n```text\n{out}```\n" if out else ""))
            end = block.end()
            if out != (block["shown"] or ""):
                wrong += 1
                print(f"{page}:{line}: prints\n{out}\ninstead of\n{block['shown'] or ''}")
        os.chdir(ROOT)
    if write:
        page.write_text("".join(made) + text[end:], encoding="utf-8")
        return 0
    print(f"{page.name}: {len(made)} blocks, {wrong} print something else")
    assert len(made) == text.count("```python\n") > 5
    return wrong


def main():
    os.environ["SLIPDISK_LIBRARY"] = str(LIBRARY)
    os.environ.setdefault("SLIPDISK_PROGRAM", str(BUILD / "slipdisk"))
    sys.path.insert(0, str(ROOT / "tools" / "python"))
    sys.dont_write_bytecode = True
    warnings.simplefilter("error")
    return 1 if sum([follow(page, "--write" in sys.argv) for page in PAGES]) else 0


if __name__ == "__main__":
    sys.exit(main())
