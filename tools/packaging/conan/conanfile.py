"""conan create tools/packaging/conan: the libraries, from the tree that this file stands in."""
import pathlib

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class Quoin(ConanFile):
    name = "quoin"
    version = "0.3.0"
    license = "BSD-3-Clause"
    description = "Contact geometry of convex polyhedra and 3-D discontinuous deformation analysis"
    settings = "os", "compiler", "build_type", "arch"
    options = {"shared": [True, False], "fPIC": [True, False]}
    default_options = {"shared": False, "fPIC": True}
    requires = "eigen/3.4.0", "fcl/0.7.0"
    generators = "CMakeDeps"

    def export_sources(self):
        root = pathlib.Path(self.recipe_folder).parents[2]
        for pattern in ("CMakeLists.txt", "LICENSE", "geometry/*", "solver/*", "tools/cmake/*"):
            copy(self, pattern, str(root), self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables.update(QUOIN_BUILD_TOOLS="OFF", QUOIN_BUILD_TESTS="OFF")
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, str(pathlib.Path(self.package_folder) / "licenses"))

    def package_info(self):
        needs = {"narrow_phase": ["eigen::eigen"], "geometry": ["narrow_phase", "fcl::fcl"],
                 "solver": ["geometry"]}
        for component, required in needs.items():
            self.cpp_info.components[component].libs = [f"quoin_{component}"]
            self.cpp_info.components[component].requires = required
            self.cpp_info.components[component].set_property("cmake_target_name", f"quoin::{component}")
        self.cpp_info.components["geometry"].system_libs = ["pthread"]
