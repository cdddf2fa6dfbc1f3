"""tools/cluster/sweep.sbatch as Slurm would run it, and the commands of docs/cluster.md for GNU parallel.

There is no Slurm here: its environment is set, and scontrol and srun are small scripts that note their arguments. The
signals are real: they go to the job's shell, as with --signal=B:, or to all of its processes.
"""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from results_common import DECK, Gate, LONG, PROGRAM, ROOT, assert_same, run, steps_for, wait_for

SCRIPT = ROOT / "tools/cluster/sweep.sbatch"
SCONTROL = """#!/bin/sh
echo "$@" >>"$CALLS"
"""
# one process in place of all tasks
SRUN = """#!/bin/sh
echo "srun $*" >>"$CALLS"
while [ "${1#-}" != "$1" ]; do shift; done
exec "$@"
"""
POINTS = 3


class Cluster(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.steps = steps_for(1)

    def setUp(self):
        self.top = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-cluster-"))
        self.addCleanup(shutil.rmtree, self.top)
        programs = self.top / "bin"
        programs.mkdir()
        for name, text in (("scontrol", SCONTROL), ("srun", SRUN)):
            (programs / name).write_text(text)
            (programs / name).chmod(0o755)
        (programs / "slipdisk").symlink_to(PROGRAM)
        (self.top / "deck.cfg").write_text(f"""@include "{DECK}"
            sweep = {{ parameters = ( {{ path = "gravity.tilt"; values = (0, "0.02 pi", "0.04 pi"); }} ); }};""")
        self.calls = self.top / "calls"
        self.calls.touch()
        self.environment = {key: value for key, value in os.environ.items() if not key.startswith("SLURM_")}
        self.environment |= {"PATH": f"{programs}:{os.environ['PATH']}", "CALLS": str(self.calls),
                             "SLURM_JOB_ID": "17"}
        self.options = ["-D", "phases.settle.steps=20000", "-D", f"phases.measure.steps={self.steps}", "-D",
                        "checkpoint=0.1", "--quiet"]
        self.points = self.top / "deck.sweep/points"

    def start(self, words=None, **environment):
        words = ["deck.cfg", *self.options] if words is None else words
        log = open(self.top / "log", "a")
        self.addCleanup(log.close)
        return subprocess.Popen(["bash", str(SCRIPT), *words], cwd=self.top, env=self.environment | environment,
                                stdout=log, stderr=log, start_new_session=True)

    def start_task(self, point, **environment):
        """A task of an array."""
        return self.start(SLURM_ARRAY_JOB_ID="12", SLURM_ARRAY_TASK_ID=str(point), **environment)

    def gated(self, workers=1):
        """The environment in which workers wait, with checkpoints, for a signal or for self.gate.open()."""
        self.gate, self.workers = Gate(self, self.top), workers
        names = "LD_PRELOAD", "ASAN_OPTIONS"
        return {key: value for key, value in self.gate.environment.items() if key in names or key.startswith("INJECT_")}

    def wait_at_gate(self, process):
        try:
            self.gate.wait(process, self.workers)
        except AssertionError as problem:
            self.fail(f"{problem}\n{(self.top / 'log').read_text()}")

    def endless(self):
        """What is only to be stopped does not end by itself, however late the signal comes."""
        self.options.append("-Dphases.measure.steps=100000000000")

    def wait(self, process, status):
        self.assertEqual(process.wait(timeout=LONG), status, (self.top / "log").read_text())

    def requeued(self):
        return self.calls.read_text().splitlines()

    def assert_undisturbed(self, point):
        """The result is that of a run that nobody stopped."""
        status, _, err = run("sweep", "deck.cfg", *self.options, "--point", point, "-o", "whole", cwd=self.top)
        self.assertEqual(status, 0, err)
        whole, = (self.top / "whole/points").glob("*.h5")
        assert_same(self, self.points / whole.name, whole)
        self.assertEqual([path.name for path in self.points.iterdir()], [whole.name])

    def test_time_limit_of_an_array_task(self):
        process = self.start_task(1, **self.gated())
        self.wait_at_gate(process)
        process.send_signal(signal.SIGUSR1)
        self.wait(process, 75)
        self.assertEqual(self.requeued(), ["requeue 12_1"])
        self.assertEqual(list(self.points.glob("*.h5")), [])
        process = self.start_task(1, SLURM_RESTART_COUNT="1")
        self.wait(process, 0)
        self.assertEqual(self.requeued(), ["requeue 12_1"])
        self.assert_undisturbed(1)
        self.wait(self.start_task(1), 0)  # done already

    def test_shares(self):
        """A task runs some of the points; the last one has fewer."""
        process = self.start_task(0, SLIPDISK_POINTS="2", **self.gated())
        self.wait_at_gate(process)
        process.send_signal(signal.SIGUSR1)
        self.wait(process, 75)
        self.assertEqual(self.requeued(), ["requeue 12_0"])
        for task in 0, 1:
            self.wait(self.start_task(task, SLIPDISK_POINTS="2", SLURM_CPUS_PER_TASK="2"), 0)
            self.assertEqual(len(list(self.points.glob("*.h5"))), min(POINTS, 2 * task + 2))
        self.assertFalse((self.top / "deck.sweep/table.csv").exists())
        self.wait(self.start_task(2, SLIPDISK_POINTS="2"), 2)

    def test_signals_to_all_processes(self):
        self.endless()
        process = self.start_task(0, **self.gated())
        self.wait_at_gate(process)
        for _ in range(3):
            os.killpg(process.pid, signal.SIGUSR1)
        self.wait(process, 75)
        self.assertEqual(self.requeued(), ["requeue 12_0"])

    def test_a_signal_at_the_very_start(self):
        """slipdisk may not be ready for it, not even begun: back into the queue all the same."""
        self.endless()
        for k in range(4):
            process = self.start_task(0)
            begun = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children")
            wait_for(begun.read_text)
            time.sleep(0.005 * k)
            process.send_signal(signal.SIGUSR1)
            self.wait(process, 75)
            self.assertEqual(self.requeued(), ["requeue 12_0"] * (k + 1))

    def test_cancelled(self):
        self.endless()
        for kind in (signal.SIGTERM, signal.SIGINT):
            process = self.start_task(0, **self.gated())
            self.wait_at_gate(process)
            process.send_signal(kind)
            self.wait(process, 75)
            self.assertEqual(self.requeued(), [])
            shutil.rmtree(self.points)

    def test_restarts_are_limited(self):
        self.endless()
        process = self.start_task(0, SLURM_RESTART_COUNT="3", SLIPDISK_RESTARTS="3", **self.gated())
        self.wait_at_gate(process)
        process.send_signal(signal.SIGUSR1)
        self.wait(process, 75)
        self.assertEqual(self.requeued(), [])
        self.assertIn("restarted 3 times", (self.top / "log").read_text())

    def test_one_node(self):
        process = self.start(SLURM_CPUS_PER_TASK="2", **self.gated(2))
        self.wait_at_gate(process)
        process.send_signal(signal.SIGUSR1)
        self.wait(process, 75)
        self.assertEqual(self.requeued(), ["requeue 17"])
        self.options[self.options.index("checkpoint=0.1")] = "checkpoint=30"
        self.wait(self.start(SLURM_CPUS_PER_TASK="2"), 0)
        self.assertEqual(len(list(self.points.glob("*.h5"))), POINTS)
        self.assertEqual(len((self.top / "deck.sweep/table.csv").read_text().splitlines()), POINTS + 1)

    def test_ranks(self):
        """With mpirun where there is one."""
        self.endless()
        launcher = os.environ.get("SLIPDISK_MPIEXEC")
        more = {"SLIPDISK_LAUNCHER": f"{launcher} -n 2"} if launcher else {}
        process = self.start(SLURM_NTASKS="2", SLURM_CPUS_PER_TASK="1", **more | self.gated(2 if launcher else 1))
        self.wait_at_gate(process)
        process.send_signal(signal.SIGUSR1)
        self.wait(process, 75)
        calls = self.requeued()
        self.assertEqual(calls.pop(), "requeue 17")
        if not launcher:
            self.assertRegex(calls.pop(), "^srun --mpi=pmix --kill-on-bad-exit=1 --cpus-per-task=1 slipdisk sweep "
                                          "--threads 1 deck.cfg ")
        self.assertEqual(calls, [])

    def test_one_run(self):
        """SLIPDISK_COMMAND=run: the deck itself, over all ranks where there are some."""
        self.options[self.options.index(f"phases.measure.steps={self.steps}")] = "phases.measure.steps=1000000000"
        launcher = os.environ.get("SLIPDISK_MPIEXEC")
        more = {"SLIPDISK_LAUNCHER": f"{launcher} -n 2", "SLURM_NTASKS": "2"} if launcher else {}
        if launcher:  # ranks share no few disks
            (self.top / "deck.cfg").write_text("""dt = 1e-4; materials = ( { name = "m"; k_n = 1e4; } );
                packings = ( { type = "square"; count = 100; x = (0, 10); y = (0, 10); radius = 0.4; mass = 1; } );
                phases = ( { name = "settle"; steps = 1; }, { name = "measure"; steps = 1; } );""")
        process = self.start(SLIPDISK_COMMAND="run", **more)
        wait_for(lambda: process.poll() is not None or list((self.top / "deck.h5.parts").glob("checkpoint*")))
        process.send_signal(signal.SIGUSR1)
        self.wait(process, 75)
        self.assertEqual(self.requeued(), ["requeue 17"])

    def test_mistakes_are_not_repeated(self):
        self.wait(self.start([]), 2)
        self.wait(self.start(SLIPDISK_COMMAND="walk"), 2)
        self.wait(self.start(SLIPDISK_COMMAND="run", SLURM_ARRAY_JOB_ID="12", SLURM_ARRAY_TASK_ID="0"), 2)
        self.wait(self.start(["none.cfg"], SLURM_ARRAY_JOB_ID="12", SLURM_ARRAY_TASK_ID="0"), 2)
        self.wait(self.start_task(POINTS), 2)
        self.assertEqual(self.requeued(), [])

    def test_a_point_is_taken_once(self):
        first = self.start_task(0, **self.gated())
        self.wait_at_gate(first)
        self.wait(self.start_task(0), 6)
        self.gate.open()
        self.assertIn("is left to another process, which runs it", (self.top / "log").read_text())
        self.wait(first, 0)
        self.assert_undisturbed(0)


class Documentation(unittest.TestCase):
    """What docs/cluster.md says is typed, with a short deck."""

    def test_commands(self):
        page = (ROOT / "docs/cluster.md").read_text()
        for title in ("One machine", "GNU parallel"):
            with self.subTest(title):
                block = re.search(rf"^### {title}\n+```sh\n(.*?)```", page, re.S | re.M).group(1)
                with tempfile.TemporaryDirectory(prefix="slipdisk-cluster-") as top:
                    self.type(pathlib.Path(top), block)

    def type(self, top, block):
        (top / "bin").mkdir()
        (top / "bin/slipdisk").symlink_to(PROGRAM)
        deck = DECK.read_text()
        for long, short in (("steps = 1e6", "steps = 1000"), ("steps = 2e7; series = 2e4", "steps = 20000")):
            self.assertIn(long, deck)
            deck = deck.replace(long, short)
        deck += 'sweep = { parameters = ( { path = "gravity.tilt"; values = (0, "0.02 pi", "0.04 pi"); } ); };'
        (top / "deck.cfg").write_text(deck)
        done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", block], cwd=top, text=True, capture_output=True,
                              env=os.environ | {"PATH": f"{top}/bin:{os.environ['PATH']}"}, timeout=LONG)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        table = (top / "deck.sweep/table.csv").read_text().splitlines()
        self.assertEqual(len(table), POINTS + 1)
        for row in table[1:]:
            self.assertIn(",done,", row)


if __name__ == "__main__":
    unittest.main()
