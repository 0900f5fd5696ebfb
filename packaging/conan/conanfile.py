"""libfvv for Conan 2: the C library. `conan create packaging/conan` builds and tries it."""

import os
import re

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load
from conan.tools.gnu import PkgConfigDeps

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")


class Fvv(ConanFile):
    name = "fvv"
    license = "Apache-2.0"
    homepage = "https://fvv.example"
    description = "Streaming file format for free-viewpoint video: meshes, pictures of many cameras, calibration, visibility, sound"
    topics = ("video", "volumetric-video", "free-viewpoint-video", "mesh", "codec")
    package_type = "library"
    settings = "os", "compiler", "build_type", "arch"
    options = {"shared": [True, False], "fPIC": [True, False]}
    default_options = {"shared": False, "fPIC": True}
    implements = ["auto_shared_fpic"]

    def set_version(self):
        self.version = re.search(
            r"project\(fvv VERSION ([\d.]+)", load(self, os.path.join(ROOT, "CMakeLists.txt"))
        ).group(1)

    def export_sources(self):
        for pattern in ("CMakeLists.txt", "LICENSE", "cmake/*", "libfvv/*", "packaging/debian.cmake"):
            copy(self, pattern, src=ROOT, dst=self.export_sources_folder)

    def requirements(self):
        self.requires("draco/1.5.6")
        self.requires("meshoptimizer/0.20")

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for part in ("FVV_MEDIA", "FVV_TOOLS", "FVV_TESTS"):
            toolchain.cache_variables[part] = False
        toolchain.generate()
        CMakeDeps(self).generate()
        PkgConfigDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", src=self.source_folder, dst=os.path.join(self.package_folder, "licenses"))
        CMake(self).install()
        # Both are built; Conan wants the one that was chosen.
        folder = os.path.join(self.package_folder, "lib")
        shared = (".so", ".dylib", ".dll")
        for name in os.listdir(folder):
            is_shared = any(end in name for end in shared)
            if os.path.isfile(os.path.join(folder, name)) and is_shared != bool(self.options.shared):
                os.remove(os.path.join(folder, name))

    def package_info(self):
        self.cpp_info.libs = ["fvv"]
        self.cpp_info.set_property("cmake_file_name", "fvv")
        self.cpp_info.set_property("cmake_target_name", "fvv::fvv")
        self.cpp_info.set_property("pkg_config_name", "fvv")
        if self.settings.os in ("Linux", "FreeBSD"):
            self.cpp_info.system_libs = ["m"]
        if not self.options.shared and self.settings.os != "Windows":
            self.cpp_info.system_libs.append("c++" if self.settings.os == "Macos" else "stdc++")
