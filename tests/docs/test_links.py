"""Links between the pages: every relative link of README.md and docs/*.md names a file that is there, and every #anchor a heading
of that page (anchors as GitHub and MyST form them)."""
import os
import pathlib
import re
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
LINK = re.compile(r"\]\(([^()\s]+)\)")
FENCE = re.compile(r"^```.*?^```", re.M | re.S)


def anchors(text):
    found = set()
    for heading in re.findall(r"^#{1,6} (.*)$", FENCE.sub("", text), re.M):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
        slug = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        count = sum(1 for other in found if re.fullmatch(re.escape(slug) + r"(-\d+)?", other))
        found.add(f"{slug}-{count}" if count else slug)
    return found | set(re.findall(r'<a (?:id|name)="([^"]+)"', text)) | set(re.findall(r"^\(([\w-]+)\)=$", text, re.M))


class Links(unittest.TestCase):
    def test_links_lead_somewhere(self):
        pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
        texts = {page.resolve(): page.read_text() for page in pages}
        broken, links = [], 0
        for page, text in texts.items():
            for link in LINK.findall(FENCE.sub("", text)):
                if re.match(r"\w+:", link):
                    continue
                links += 1
                name, _, anchor = link.partition("#")
                target = (page.parent / name).resolve() if name else page
                if not target.exists():
                    broken.append(f"{page.relative_to(ROOT.resolve())}: {link}: no such file")
                elif anchor and anchor not in anchors(texts.get(target, "")):
                    broken.append(f"{page.relative_to(ROOT.resolve())}: {link}: no such heading")
        self.assertFalse(broken, "\n" + "\n".join(broken))
        self.assertGreater(links, 50)

    def test_anchors(self):
        self.assertEqual(anchors("# Slurm: an array of jobs\n## `a_b`, c\n```\n# no\n```\n## `a_b`, c\n"),
                         {"slurm-an-array-of-jobs", "a_b-c", "a_b-c-1"})


if __name__ == "__main__":
    unittest.main()
