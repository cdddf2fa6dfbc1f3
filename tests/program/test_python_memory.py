"""Allocations of the library that fail under Python: calls that make something new raise MemoryError, nothing is false, and where the
interpreter must end it says what was saved. tests/inject/memory.c lets single allocations fail, or all from one on."""
import ctypes
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
BUILD = pathlib.Path(os.environ.get("SLIPDISK_BUILD_DIR", ROOT / "build/release"))
SHIM = BUILD / "tests/libinject_memory.so"
os.environ["SLIPDISK_LIBRARY"] = str(BUILD / "libslipdisk.so")
sys.path.insert(0, str(ROOT / "tools" / "python"))
sys.dont_write_bytecode = True
TRIALS = 40  # allocations of a call that are tried: the first, the last, and between


def calls(folder):
    """{name: (call, may it end the interpreter?)}"""
    import slipdisk
    ratchet, heap = slipdisk.inputs / "three_disk/random.cfg", slipdisk.inputs / "packing/heap.cfg"
    s = slipdisk.Simulation(ratchet)
    s.advance(3000)
    s.save(folder / "s.h5")
    data = s.to_bytes()
    return s, {
        "deck": (lambda: slipdisk.Simulation(ratchet), False), "dict": (lambda: slipdisk.Simulation({"dt": 1e-3, "materials": {"grain": {"k_n": 1e4}}},
                                                                         disks={"x": [0, 3], "y": 0, "radius": 1, "mass": 1}), False),
        "packing": (lambda: slipdisk.Simulation(heap, threads=2), False), "advice": (lambda: slipdisk.Simulation(ratchet, {"dt": 5e-5}), False),
        "mistakes": (lambda: slipdisk.Simulation({"dt": -1, "tme": 3}), False), "clone": (s.clone, False), "measure": (s.measure, False),
        "advance": (lambda: s.advance(2000), False), "contacts": (lambda: s.contacts, False), "rotation": (lambda: s.rotation, False),
        "save": (lambda: s.save(folder / "other.h5"), True), "to_bytes": (s.to_bytes, True), "load": (lambda: slipdisk.Simulation.load(folder / "s.h5"), False),
        "from_bytes": (lambda: slipdisk.Simulation.from_bytes(data), False), "set": (lambda: s.set("vx", 1.0, 0), True),
        "add_disks": (lambda: s.add_disks(x=9, y=90, radius=0.1, mass=1), True), "observe": (lambda: s.observe(1, print), True),
        "add_force": (lambda: s.add_force(lambda c: None), True)}


def trials(folder):
    """Prints a line for each call: its name, how many allocations, how many trials ended which way; what is wrong goes to stderr."""
    import warnings

    import slipdisk
    warnings.simplefilter("ignore")
    shim, (s, table) = ctypes.CDLL(None), calls(folder)
    shim.inject_begin.argtypes, shim.inject_end.restype = [ctypes.c_void_p, ctypes.c_long, ctypes.c_int], ctypes.c_long
    inside = ctypes.cast(slipdisk.library.library().sd_version, ctypes.c_void_p)

    def outcome(call, may_end, at, on, before):
        """What a child process says that calls with the allocation number `at` failing."""
        shim.inject_begin(inside, at, on)
        try:
            call()
            said = "done"
        except MemoryError as error:
            said = "raised" if isinstance(error, slipdisk.OutOfMemory) and "memory" in str(error) else f"bare {error!r}"
        except slipdisk.UserError:
            said = "done" if call is table["mistakes"][0] else "wrong"
        made = shim.inject_end()
        if said == "raised":
            try:
                said = said if s.hash() == before else "changed"
            except slipdisk.UserError as lost:  # a change that could not be ended
                said = "raised" if may_end and "memory ran out" in str(lost) else f"lost {lost}"
        return f"{said} {made}"

    for name, (call, may_end) in table.items():
        def child(at, on):
            r, w = os.pipe()
            pid = os.fork()
            if pid == 0:
                signal.alarm(60)
                os.dup2(w, 2)
                os.write(w, b"\n" + outcome(call, may_end, at, on, s.hash()).encode())
                os._exit(0)
            os.close(w)
            with open(r, "rb") as pipe:
                said = pipe.read().decode()
            status = os.waitpid(pid, 0)[1]
            return said if status == 0 else f"{said}\nsignal {os.WTERMSIG(status)} 0"
        n = int(child(0, 0).split()[-1])
        counts = dict.fromkeys(("done", "raised", "ended"), 0)
        for on in (0, 1):
            for at in sorted({1 + k * (n - 1) // (TRIALS - 1) for k in range(TRIALS)}) if n else ():
                said = child(at, on)
                word = said.rsplit("\n", 1)[-1].rsplit(" ", 1)[0]
                if word == "signal 6" and f"the interpreter ends, since the library cannot go on; saved last: {folder / 's.h5'}, step 3000\n" in said:
                    word = "ended"
                # The list of messages of a new simulation is made outside of what can be left
                if word not in counts or word == "ended" and not may_end and at > 1:
                    print(f"{name}: allocation {at} of {n}{' and all later' * on} fails: {said!r}", file=sys.stderr)
                counts[word] = counts.get(word, 0) + 1
        print(f"{name:12}{n:6} allocations: {counts['done']} right, {counts['raised']} MemoryError, {counts['ended']} ended")


class Memory(unittest.TestCase):
    def test_every_call(self):
        with tempfile.TemporaryDirectory(prefix="slipdisk-test-") as folder:
            done = subprocess.run([sys.executable, __file__, "trials", folder], env={**os.environ, "LD_PRELOAD": str(SHIM)}, capture_output=True, text=True)
        print(done.stdout)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(done.stdout.count(" allocations: "), 18)
        raised = [int(line.split("right, ")[1].split()[0]) for line in done.stdout.splitlines()]
        self.assertGreater(sum(raised), 500)


if __name__ == "__main__":
    if sys.argv[1:2] == ["trials"]:
        trials(pathlib.Path(sys.argv[2]))
    else:
        unittest.main()
