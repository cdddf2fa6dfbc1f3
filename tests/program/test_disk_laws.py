"""Disks and contacts from the result of another run, by law and body: the run goes on as if it had not ended."""
import unittest

import h5py
import numpy

from results_common import changed
from test_disk_files import Files, contacts


class Laws(Files):
    """Six disks over three bodies, in the middle of an impact: what goes on is the run that was not interrupted."""
    LAWS = {"linear": "mu = 0.5;", "slides": "mu = 0.1; mu_kinetic = 0.05;",
            "critical": "mu = 0.1; mu_kinetic = 0.05; critical_load = 1;",
            "mindlin": 'law = "hertz"; tangential = "mindlin"; mu = 0.1; mu_kinetic = 0.05;',
            "modulus": 'law = "hertz"; E_star = 3e5; tangential = "mindlin"; poisson = 0.3; mu = 0.1; mu_kinetic = 0.05;',
            "range": 'mu = 0.1; mu_kinetic = 0.05; cohesion = "constant"; pull_off = 0.5; range = 1e-4;',
            "bridge": 'mu = 0.1; mu_kinetic = 0.05; cohesion = "bridge"; pull_off = 0.5; range = 1e-3; rupture = 2e-3;',
            "viscous": "mu = 0.1; gamma_n = 2;", "restitution": "mu = 0.5; restitution = 0.4; limit_damping = false;",
            "dashpots": "mu = 0.5; gamma_n = 2; gamma_t = 1; k_r = 2e3; gamma_r = 1; mu_r = 0.1;",
            "rolls": "mu = 0.5; k_r = 2e3; mu_r = 0.1;", "rolls_stuck": "mu = 0.5; k_r = 2e3; mu_r = 5;"}
    BODIES = {"polyline": 'walls = ( { name = "w"; type = "polyline"; points = ( (-0.2, 0), (0, 0), (0.2, 0) ); } );',
              "turning line": 'walls = ( { name = "w"; type = "line"; points = ( (-0.2, 0), (0.2, 0) ); } );'
                              ' motions = ( { wall = "w"; coordinate = "theta"; type = "velocity"; velocity = 0.1; } );',
              "turning circle": 'walls = ( { name = "w"; type = "circle"; center = (0, -0.3); radius = 0.3;'
                                ' side = "outside"; } );'
                                ' motions = ( { wall = "w"; coordinate = "theta"; type = "velocity"; velocity = 0.5; } );',
              "fixed disks": ""}

    def rows(self, result, moment):
        found = contacts(result, moment)
        return {key: (found["force"][k], found["tau"][k])
                for k, key in enumerate(zip(found["a"], found["b"], found["part"]))}

    def test_goes_on_over_laws_and_bodies(self):
        for law, keys in self.LAWS.items():
            for body, walls in self.BODIES.items():
                if body != "polyline" and law not in ("slides", "rolls_stuck", "dashpots"):
                    continue
                for integrator, share in (("verlet", 1e-9), ("gear5", 1e-7)):
                    self.goes_on(law, keys, body, walls, integrator, share)

    def goes_on(self, law, keys, body, walls, integrator, share):
        stiffness = "" if "E_star" in keys else f"k_n = 1e4; k_t = {5e4 if 'hertz' in keys else 5e3};"
        head = (f'integrator = "{integrator}"; dt = 2e-5; gravity = {{ g = 9.81; tilt = 0.2; }}; materials = ( {{ name = "m";'
                f" {stiffness} {keys} }} ); {walls}")
        at = ((-0.0405, 0.0198, 0), (0, 0.0199, 3.9985), (0.0403, 0.0205, 1e5), (-0.02, 0.0545, -2),
              (0.0203, 0.0544, 7), (0, 0.0887, 0.3))
        rows = []
        for k, (x, y, theta) in enumerate(at):
            fixed = body == "fixed disks" and k < 3
            y += (0.09 - x * x) ** 0.5 - 0.3 if "circle" in body else 0
            rows.append(f"({x}, {y}, 0.02, {theta}, {int(fixed)}, {0 if fixed else 3 + k})")
        disks = ('disk_rows = ( { columns = ("x", "y", "radius", "theta", "fixed", "omega"); density = 3.57;'
                 f' rows = ({", ".join(rows)}); }} );')
        self.run_deck(f"{head} {disks} steps = 30;", name="one")
        if integrator == "gear5" and "mu_kinetic" in keys:  # the columns are read by their names
            with changed(self.folder / "one.h5") as f:
                laws = f["parameters/model/general_laws"]
                laws[...] = laws[...][:, :, ::-1]
                laws.attrs["description"] = b", ".join(laws.attrs["description"].split(b", ")[::-1])
        whole = self.run_deck(f"{head} {disks} phases = ( {{ steps = 30; }}, {{ steps = 10; contacts = 1; }} );",
                              name="whole")
        again = self.run_deck(f'{head} disk_files = ( {{ file = "one.h5"; contacts = true; }} );'
                              " phases = ( { steps = 10; contacts = 1; } );", name="again")
        with h5py.File(whole) as f, h5py.File(again) as g:
            if "k_r" not in keys:  # the angle of a disk has been wrapped in between
                self.assertFalse(f["state/contact_rho_ref"][()].any(), (law, body))
            first, n = list(f["contacts/step"][()]).index(31), list(g["contacts/step"][()]).index(1)
        for step in range(10):
            a, b = self.rows(whole, first + step), self.rows(again, n + step)
            self.assertEqual(a.keys(), b.keys(), (law, body, step))
            self.assertGreaterEqual(len(a), 2 if step == 0 else 1, (law, body, step))
            most = max(force for force, _ in a.values())
            for key in a:
                self.assertLess(numpy.abs(numpy.subtract(a[key], b[key])).max(), share * most,
                                (law, body, integrator, step, key))

    def test_first_slip_in_the_last_step(self):
        """Forces that are worked out anew, here since the deck has an omega, keep the limit that they had, that of static friction."""
        for law in "", "critical_load = 0.3;", 'cohesion = "constant"; pull_off = 0.5; range = 1e-4;':
            head = ('integrator = "verlet"; dt = 2e-5; gravity = { g = 100; }; materials = ( { name = "m"; k_n = 1e4; k_t = 5e3; mu = 0.1;'
                    f' mu_kinetic = 0.08; {law} }} ); walls = ( {{ type = "line"; points = ( (-1, 0), (1, 0) ); }} ); ')
            disk = 'disks = ( { x = 0; y = 0.01995; radius = 0.02; mass = 0.005; vx = 0.2; locked = ("theta"); } ); '
            with h5py.File(self.run_deck(head + disk + "steps = 60; output = { contacts = 1; };", name="whole")) as f:
                slides = [int(step) for step, k in zip(f["contacts/step"][()], f["contacts/first"][()]) if f["contacts/sliding"][k]]
                tau = {int(step): f["contacts/tau"][k] for step, k in zip(f["contacts/step"][()], f["contacts/first"][()])}
            first = slides[0]
            self.assertGreater(first, 1)
            self.run_deck(f"{head}{disk}steps = {first};", name="one")
            again = self.run_deck(head + 'disk_files = ( { file = "one.h5"; contacts = true; omega = 0; locked = "theta"; } );'
                                  " steps = 5; output = { contacts = 1; };")
            with h5py.File(again) as f:
                for k in range(6):
                    self.assertAlmostEqual(f["contacts/tau"][k], tau[first + k], 11, (law, k))

    def test_rolling_that_the_file_does_not_have(self):
        """Its spring begins relaxed, whatever the angles."""
        disks = ('walls = ( { name = "w"; type = "line"; points = ( (-1, 0), (1, 0) ); } ); disk_rows = ( { columns = ("x",'
                 ' "y", "radius", "theta", "omega"); density = 3.57; rows = ( (0, 0.0199, 0.02, 2.3, 4), (0.05, 0.0199,'
                 ' 0.02, -3.1, 0) ); } );')
        head = ('integrator = "verlet"; dt = 2e-5; gravity = { g = 9.81; }; materials = ( { name = "m"; k_n = 1e4; k_t = 1e3;'
                " mu = 0.5; %s } ); ")
        self.run_deck(head % "" + disks + " steps = 20;", name="one")
        again = self.run_deck(head % "k_r = 1e3; mu_r = 0.1;" + 'disk_files = ( { file = "one.h5"; contacts = true; } );'
                              + disks.partition("disk_rows")[0] + " steps = 1;")
        with h5py.File(again) as f:
            self.assertEqual(len(f["state/contact_rho"][()]), 2)
            omega, dt = f["particles/disks/angular_velocity/value"][-1], 2e-5
            rolled = f["state/contact_rho"][()]
        self.assertTrue(numpy.allclose(rolled, 0.02 * omega * dt, rtol=1e-2, atol=1e-12), rolled)

    FALL = ('dt = 2e-5; gravity = { g = 9.81; }; materials = ( { name = "m"; k_n = 1e4; k_t = 1e3; mu = 0.1; mu_kinetic = 0.05;'
            ' %s } ); walls = ( { name = "w"; type = "line"; points = ( (-1, 0), (1, 0) ); } ); ')
    THREE = ('disk_rows = ( { columns = ("x", "y", "radius", "vx", "vy", "omega"); density = 3.57; rows = ( (0, 0.0199, 0.02, 0.3,'
             ' -0.2, 9), (0.041, 0.0199, 0.02, -0.4, -0.2, 0), (0.02, 0.0545, 0.02, 0.2, -0.1, -5) ); } );')

    def test_coordinates_that_are_held_now(self):
        """A lock or a motion drops what the file says of the velocity there, and of its derivatives."""
        self.run_deck('integrator = "gear5";' + self.FALL % "gamma_n = 1;" + self.THREE + " steps = 30;", name="one")
        file = 'disk_files = ( { file = "one.h5"; contacts = true; %s } );'
        for what in (file % 'locked = "x";', file % "" + ' locks = ( { disk = (0, 1, 2); coordinates = "x"; } );',
                     file % "" + ' motions = ( { disk = (0, 1, 2); coordinate = "x"; type = "fixed"; } );'):
            with self.subTest(what=what):
                again = self.run_deck(f'integrator = "gear5"; {self.FALL % "gamma_n = 1;"} {what} steps = 20; output = {{ frames = 1; }};')
                with h5py.File(again) as f, h5py.File(self.folder / "one.h5") as g:
                    places = f["particles/disks/position/value"][()]
                    self.assertTrue((places[:, :, 0] == g["particles/disks/position/value"][-1][:, 0]).all())
                    self.assertGreater(numpy.ptp(places[:, :, 1], axis=0).min(), 0)
                    self.assertFalse(f["state/x3"][()].any())
                    self.assertTrue(f["state/y3"][()].all())

    def test_attraction_that_the_deck_does_not_have(self):
        """A contact that slid under a pull is one without."""
        self.run_deck(self.FALL % 'cohesion = "constant"; pull_off = 0.5; range = 1e-4;' + self.THREE + " steps = 30;", name="one")
        self.assertTrue(contacts(self.folder / "one.h5", -1)["sliding"].any())
        again = self.run_deck(self.FALL % "" + 'disk_files = ( { file = "one.h5"; contacts = true; } ); steps = 1;')
        with h5py.File(again) as f:
            self.assertGreater(len(f["state/contact_pull"][()]), 0)
            self.assertFalse(f["state/contact_pull"][()].any())

    def test_velocities_of_the_deck(self):
        """With them the file's forces do not hold: a disk at rest is not damped."""
        head = 'integrator = "verlet";' + self.FALL % "gamma_n = 2;"
        self.run_deck(head + self.THREE + " steps = 30;", name="one")
        again = self.run_deck(f'{head} disk_files = ( {{ file = "one.h5"; contacts = true; vx = 0; vy = 0; omega = 0; }} );'
                              " steps = 10; output = { contacts = 1; };")
        first, old = contacts(again, 0), contacts(self.folder / "one.h5", -1)
        self.assertTrue(numpy.allclose(first["force"], 1e4 * first["overlap"], rtol=1e-12))
        self.assertGreater(abs(old["force"] / (1e4 * old["overlap"]) - 1).max(), 0.1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
