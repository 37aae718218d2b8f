"""The .deb packages, unpacked into an empty root: the command runs, a program links by pkg-config, Python imports."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

build, version = pathlib.Path(sys.argv.pop(1)).resolve(), sys.argv.pop(1)
PROGRAM = """
#include <cstdio>
#include <quoin/geometry.hpp>
#include <quoin/geometry/build.hpp>
#include <quoin/geometry_c.h>
int main() {
  quoin::geometry::ContactFinder finder({.reach = 1e-3});
  const auto box = std::make_shared<const quoin::geometry::Shape>(quoin::geometry::make_box({0, 0, 0}, {1, 1, 1}));
  finder.add(box);
  finder.add(box, {.translation = {0, 0, 1}});
  std::vector<quoin::geometry::ContactPoint> contacts;
  finder.find(contacts);
  std::printf("%zu contacts", contacts.size());
}
"""


def run(*command, **more):
    done = subprocess.run([str(word) for word in command], text=True, capture_output=True, **more)
    if done.returncode != 0:
        raise AssertionError(f"{command}: {done.stdout}{done.stderr}")
    return done.stdout


class Packages(unittest.TestCase):
    def test_unpacked_into_an_empty_root(self):
        with tempfile.TemporaryDirectory() as name:
            folder, root = pathlib.Path(name), pathlib.Path(name) / "root"
            root.mkdir()
            run("cpack", "-G", "DEB", "--config", build / "CPackConfig.cmake", "-B", folder / "out",
                "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=none", cwd=folder)
            packages = {path.name.split("_")[0]: path for path in (folder / "out").glob("*.deb")}
            self.assertEqual(sorted(packages), ["libquoin-dev", "python3-quoin", "quoin"])
            for package, path in packages.items():
                self.assertRegex(path.name, rf"^{package}_{version}_\w+\.deb$")
                run("dpkg-deb", "-x", path, root)
                self.assertTrue((root / "usr/share/doc" / package / "copyright").exists())
            self.assertIn("python3-numpy", run("dpkg-deb", "-f", packages["python3-quoin"], "Depends"))
            self.assertIn("libc6", run("dpkg-deb", "-f", packages["quoin"], "Depends"))
            self.assertIn(version, run(root / "usr/bin/quoin", "--version"))

            environment = {**os.environ, "PKG_CONFIG_PATH": str(root / "usr/lib/pkgconfig")}
            flags = run("pkg-config", "--cflags", "--libs", "quoin-geometry", env=environment).split()
            self.assertEqual(run("pkg-config", "--modversion", "quoin-solver", env=environment).strip(), version)
            (folder / "main.cpp").write_text(PROGRAM)
            run("g++", folder / "main.cpp", "-o", folder / "program", *flags, "-std=c++20")
            self.assertEqual(run(folder / "program"), "4 contacts")

            environment = {**os.environ, "PYTHONPATH": str(root / "usr/lib/python3/dist-packages")}
            self.assertEqual(run(sys.executable, "-c", "import quoin; print(quoin.__file__)", env=environment).strip(),
                             f"{root}/usr/lib/python3/dist-packages/quoin/__init__.py")


if __name__ == "__main__":
    unittest.main()
