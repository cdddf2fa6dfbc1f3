"""The version stands in include/slipdisk/version.h; program, library, changelog and citation say the same, with the same day."""
import json
import os
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
HEADER = dict(re.findall(r"#define SD_(VERSION\w*) \"?([\w.-]+)\"?", (ROOT / "include/slipdisk/version.h").read_text()))
VERSION, DAY = HEADER["VERSION"], HEADER["VERSION_DATE"]


class Version(unittest.TestCase):
    def test_header(self):
        self.assertEqual(VERSION, ".".join(HEADER[f"VERSION_{part}"] for part in ("MAJOR", "MINOR", "PATCH")))
        self.assertRegex(DAY, r"^20\d\d-\d\d-\d\d$")

    def test_program(self):
        told = subprocess.run([PROGRAM, "version"], capture_output=True, text=True, check=True).stdout
        self.assertTrue(told.startswith(f"slipdisk {VERSION} ("), told)

    def test_changelog(self):
        text = (ROOT / "docs/changelog.md").read_text()
        entries = re.findall(r"^## \[(\d+)\.(\d+)\.(\d+)\] - (\d{4}-\d\d-\d\d)$", text, re.M)
        self.assertEqual(len(entries), len(re.findall("^## (?!Next$)", text, re.M)))
        self.assertEqual((".".join(entries[0][:3]), entries[0][3]), (VERSION, DAY))
        numbers = [tuple(map(int, entry[:3])) for entry in entries]
        self.assertEqual(numbers, sorted(set(numbers), reverse=True))

    def test_commands_of_the_pages(self):
        """Names of packages and versions asked for, in pages and tools: slipdisk@..., slipdisk_..., slipdisk-..., find_package."""
        name, found = re.compile(r"slipdisk(?:[@_-]|==|-v)(\d+\.\d+\.\d+)|find_package\(slipdisk (\d[\d.]*)"), 0
        for path in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "docs/cookbook").glob("*.md"), *(ROOT / "tools").rglob("*")):
            if not path.is_file() or path.name == "changelog.md":
                continue
            for match in name.finditer(path.read_text(encoding="utf-8", errors="replace")):
                self.assertEqual(match[1] or match[2], VERSION, path)
                found += 1
        self.assertGreater(found, 1)

    def test_citation(self):
        text = (ROOT / "CITATION.cff").read_text()
        self.assertEqual(re.findall(r"^version: (\S+)", text, re.M), [VERSION])
        self.assertEqual(re.findall(r"^date-released: (\S+)", text, re.M), [DAY])
        for key in ("cff-version: 1.2.0", "title:", "abstract:", "authors:", "license: MIT", "references:"):
            self.assertRegex(text, rf"(?m)^{key}")

    def test_what_archives_read(self):
        codemeta = json.loads((ROOT / "codemeta.json").read_text())
        self.assertEqual((codemeta["version"], codemeta["license"]), (VERSION, "https://spdx.org/licenses/MIT"))
        self.assertEqual(json.loads((ROOT / ".zenodo.json").read_text())["license"], "MIT")

    def test_workflows(self):
        """Those of a public forge: YAML, and each step that runs one of our scripts finds it."""
        import yaml
        scripts = []
        for path in sorted((ROOT / ".github/workflows").glob("*.yml")):
            steps = [step for job in yaml.safe_load(path.read_text())["jobs"].values() for step in job["steps"]]
            self.assertTrue(all(("run" in step) != ("uses" in step) for step in steps), path)
            scripts += [word for step in steps for word in re.findall(r"(?:\./)?(tools/\S+\.sh)", step.get("run", ""))]
        self.assertEqual([name for name in scripts if not os.access(ROOT / name, os.X_OK)], [])
        self.assertGreater(len(scripts), 2)

    def test_packages(self):
        """Recipes of conda and Spack: the version, and what this machine can check of their syntax."""
        recipe = (ROOT / "tools/packaging/conda/meta.yaml").read_text()
        self.assertEqual(re.findall(r'^{% set version = "(\S+)" %}$', recipe, re.M), [VERSION])
        package = (ROOT / "tools/packaging/spack/package.py").read_text()
        self.assertEqual(re.findall(r'^    version\("(\S+)"\)$', package, re.M), [VERSION])
        compile(package, "package.py", "exec")
        import jinja2
        import yaml
        read = yaml.safe_load(jinja2.Environment(undefined=jinja2.StrictUndefined).from_string(recipe).render(
            compiler=lambda language: language + "_compiler"))
        self.assertEqual(read["package"], {"name": "slipdisk", "version": VERSION})
        options = set(re.findall(r"(?:option\(|set\()(\w+)[^\n]*(?:ON|OFF|CACHE)", (ROOT / "CMakeLists.txt").read_text()))
        for told in (" ".join(read["build"]["script"]), package):
            used = re.findall(r"(?:-D|\")((?:SLIPDISK|BUILD)_[A-Z_]+)", told)
            self.assertGreater(len(used), 2, told)
            self.assertEqual(set(used) - options, set(), "no options of CMakeLists.txt")

    def test_python(self):
        if os.environ.get("SLIPDISK_BRIEF") == "1":
            self.skipTest("slow builds have no shared library")
        sys.path.insert(0, str(ROOT / "tools/python"))
        build = os.environ.get("SLIPDISK_BUILD_DIR", str(ROOT / "build/release"))
        os.environ.setdefault("SLIPDISK_LIBRARY", f"{build}/libslipdisk.so")
        import slipdisk
        self.assertEqual(slipdisk.version(), VERSION)


if __name__ == "__main__":
    unittest.main()
