"""Metadata is in pyproject.toml; here: the extension is built by CMake, and what makes view()'s page is copied."""
import os
import pathlib
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

SOURCE = pathlib.Path(__file__).resolve().parent


class WithTools(build_py):
    def run(self):
        super().run()
        for name in ("view.py", "run_output.py", "viewer/dist/page.html"):
            copy = pathlib.Path(self.build_lib) / "quoin/_tools" / name
            copy.parent.mkdir(parents=True, exist_ok=True)
            self.copy_file(str(SOURCE / "tools" / name), str(copy))


class CMakeBuild(build_ext):
    def build_extension(self, ext):
        folder = pathlib.Path(self.get_ext_fullpath(ext.name)).resolve().parent
        built = os.environ.get("QUOIN_BUILD_FOLDER")  # where the module is built already
        build = pathlib.Path(built or self.build_temp).resolve()
        if not built:
            self.build_module(build)
        folder.mkdir(parents=True, exist_ok=True)
        for library in (build / "tools/python/quoin").glob("_quoin*.so"):
            self.copy_file(str(library), str(folder / library.name))

    def build_module(self, build):
        settings = [f"-DPython_EXECUTABLE={sys.executable}", "-DQUOIN_BUILD_PYTHON=ON", "-DQUOIN_BUILD_TESTS=OFF",
                    "-DCMAKE_BUILD_TYPE=Release"]
        try:  # from PyPI; else CMake finds Debian's pybind11-dev
            import pybind11
            settings.append(f"-Dpybind11_DIR={pybind11.get_cmake_dir()}")
        except ImportError:
            pass
        settings += os.environ.get("CMAKE_ARGS", "").split()
        subprocess.run(["cmake", "-S", SOURCE, "-B", build, *settings], check=True)
        jobs = str(self.parallel or os.cpu_count() or 1)
        subprocess.run(["cmake", "--build", build, "--target", "quoin_python", "-j", jobs], check=True)


setup(ext_modules=[Extension("quoin._quoin", sources=[])], cmdclass={"build_ext": CMakeBuild, "build_py": WithTools})
