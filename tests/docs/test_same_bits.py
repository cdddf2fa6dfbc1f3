"""The rooms whose bits docs/reliability.md promises call of the C library and of GSL only what its table lists, with the reason
why the bits are the same everywhere; they are compiled without contraction, and have no long double.

What they call is read from the object files of the build (nm).
"""
import ctypes
import json
import pathlib
import re
import subprocess
import unittest

from test_circles import BUILD, SRC, objects, symbols

PAGE = SRC.parent / "docs/reliability.md"
ROOMS = ("base/", "model/", "physics/", "measure/", "pack/", "run/", "io/deck/", "io/results/")
# of the C library, beside libm: numbers from texts, orders, random numbers
OTHERS = {"strtod", "sscanf", "strtof", "strtold", "atof", "snprintf", "qsort", "qsort_r", "rand", "rand_r", "random", "drand48", "erand48",
          "frexp", "ldexp", "modf", "scalbn", "copysign"}


def functions_of_libm():
    ctypes.CDLL("libm.so.6")
    path = next(line.split()[-1] for line in pathlib.Path("/proc/self/maps").read_text().splitlines() if "/libm" in line)
    said = subprocess.run(["nm", "-D", "--defined-only", path], check=True, stdout=subprocess.PIPE, text=True).stdout
    return {line.split()[-1].split("@")[0] for line in said.splitlines()}


def listed():
    """symbols in the first column of the table"""
    table = PAGE.read_text().split("<!-- calls -->")[1].split("<!-- end of calls -->")[0]
    return [name for line in table.splitlines() if line.startswith("|`") for name in re.findall(r"`(\w+)`", line.split("|")[1])]


class SameBits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        numbers = functions_of_libm() | OTHERS
        assert {"sin", "exp", "hypot", "fmax", "fma"} < numbers
        cls.calls = {}
        for name, (_, needs) in symbols(objects()).items():
            for symbol in needs if name.startswith(ROOMS) else ():
                plain = re.sub(r"^__(?:isoc99_)?(\w+?)(?:_chk|_finite)?$", r"\1", symbol)
                if plain in numbers or plain.startswith("gsl_"):
                    cls.calls.setdefault(plain, []).append(name)

    def test_only_what_the_table_lists(self):
        known = set(listed())
        told = [f"{symbol} is called by {', '.join(sorted(names))}, and not listed in {PAGE.name}: base/math.h has functions with the "
                "same bits everywhere" for symbol, names in sorted(self.calls.items()) if symbol not in known]
        self.assertFalse(told, "\n" + "\n".join(told))

    def test_the_table_lists_nothing_else(self):
        names = listed()
        self.assertEqual(sorted(names), sorted(set(names)))
        # a compiler may do the small ones itself, and leave no symbol
        small = {"sqrt", "fabs", "floor", "ceil", "copysign", "nearbyint", "frexp", "ldexp", "fma"}
        self.assertFalse(set(names) - set(self.calls) - small)

    def test_no_contraction(self):
        found = json.loads((BUILD / "compile_commands.json").read_text())
        ours = [entry for entry in found if entry["file"].startswith(tuple(f"{SRC}/{room}" for room in ROOMS))]
        self.assertGreater(len(ours), 100)
        for entry in ours:
            self.assertIn(" -ffp-contract=off", entry["command"], entry["file"])
            self.assertNotRegex(entry["command"], r" -ffast-math| -Ofast| -mfma| -funsafe-math", entry["file"])

    def test_no_long_double(self):
        for path in SRC.glob("**/*.[ch]"):
            if path.relative_to(SRC).as_posix().startswith(ROOMS):
                code = re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.S)
                self.assertNotRegex(code, r"\blong double\b|__float128|\b\d[\d.]*(e[-+]?\d+)?L\b(?!L)", path)


if __name__ == "__main__":
    unittest.main()
