"""The tables of docs/reliability.md, from what the modes have left in build/soak."""
import json

BEGIN, END = "<!-- trials: tools/soak.sh --keep docs -->\n", "<!-- end of trials -->\n"


def avx512():
    with open("/proc/cpuinfo") as info:
        return "with AVX-512" if " avx512f " in info.read().replace("\n", " ") else "without AVX-512"


def table(found):
    lines = [f"**{found['mode']}**: {found['what']} (size {found['size']}, {found['seconds']:.0f} s)", "",
             "| trial | made | failed | note |", "|---|---|---|---|"]
    for row in found["rows"]:
        note = row["note"].replace("|", "\\|").replace("\n", " ")
        lines.append(f"| {row['what']} | {row['trials']} | {row['failed']} | {note} |")
    return "\n".join(lines) + "\n"


def keep(folder, page, modes):
    """Puts the tables of all modes that were run into the page."""
    tables = []
    for mode in modes:
        path = folder / f"{mode}.json"
        if path.exists():
            tables.append(table(json.loads(path.read_text())))
    text = page.read_text()
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    page.write_text(before + BEGIN + f"\nOn a machine {avx512()}.\n\n" + "\n".join(tables) + "\n" + END + after)
