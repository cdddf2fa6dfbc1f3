"""The tables of docs/reliability.md, from what the modes have left in build/soak."""
import json

BEGIN, END = "<!-- trials: tools/soak.sh --keep docs -->\n", "<!-- end of trials -->\n"


def avx512():
    with open("/proc/cpuinfo") as info:
        return "with AVX-512" if " avx512f " in info.read().replace("\n", " ") else "without AVX-512"


HEAD = "| trial | what is tried | made | of kinds | failed | time |\n|---|---|---:|---:|---:|---:|\n"


def line(found):
    made, failed = (sum(row[key] for row in found["rows"]) for key in ("trials", "failed"))
    return f"| `{found['mode']}` | {found['what']} | {made} | {len(found['rows'])} | {failed} | {found['seconds']:.0f} s |\n"


def failures(found):
    """A line for each kind of trial of which some failed."""
    return "".join(f"- {found['mode']}: {row['what']}: {row['failed']} of {row['trials']} failed; {row['note']}\n"
                   for row in found["rows"] if row["failed"])


def keep(folder, page, modes):
    """Puts the sums of all modes that were run into the page, and what failed."""
    paths = [folder / f"{mode}.json" for mode in modes]
    every = [json.loads(path.read_text()) for path in paths if path.exists()]
    sizes = ", ".join(sorted({found["size"] for found in every}))
    text = page.read_text()
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    page.write_text(before + BEGIN + f"\nSize {sizes}, on a machine {avx512()}; each kind is a row that `tools/soak.sh` prints.\n\n"
                    + HEAD + "".join(map(line, every)) + "\n" + "".join(map(failures, every)) + END + after)
