"""Spack package, for a repository of your own: docs/install.md. The source is a clone (`spack dev-build`), so the version has no
checksum. tests/docs/test_version.py compares it with include/slipdisk/version.h."""
from spack.package import *


class Slipdisk(CMakePackage):
    """2D discrete-element engine for frictional disks: program, C library and Python package."""

    license("MIT")

    version("0.6.0")

    variant("mpi", default=False, description="Runs and sweeps over the ranks of an MPI job")
    variant("live", default=True, description="Runs can be shown in a browser while they go on")

    depends_on("c", type="build")
    depends_on("cmake@3.22:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("python@3.10:", type=("build", "run"))
    depends_on("py-numpy@1.22:", type="run")
    depends_on("py-h5py@3.6:", type="run")
    depends_on("gsl")
    depends_on("hdf5")
    depends_on("jansson")
    depends_on("libconfig")
    depends_on("xxhash@0.8:")
    depends_on("zlib-api")
    depends_on("libmicrohttpd", when="+live")
    depends_on("mpi", when="+mpi")
    depends_on("trilinos+zoltan", when="+mpi")

    extends("python")

    def cmake_args(self):
        return [
            self.define_from_variant("SLIPDISK_MPI", "mpi"),
            self.define_from_variant("SLIPDISK_LIVE", "live"),
            self.define("SLIPDISK_TESTS", False),
            self.define("SLIPDISK_WERROR", False),
            self.define("SLIPDISK_PYTHON_DIR", self.spec["python"].package.platlib),
        ]
