# SPDX-License-Identifier: Apache-2.0
"""A Conan 2 recipe of the SDK. Never run. From a checkout: conan create tools/packaging/conan --build=missing"""
import pathlib
import re

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain
from conan.tools.files import copy

SOURCE = pathlib.Path(__file__).resolve().parent.parent.parent.parent


class Doppel(ConanFile):
    name = "doppel"
    license = "Apache-2.0"
    description = "Draws drivable photoreal splat avatars"
    settings = "os", "arch", "compiler", "build_type"
    package_type = "shared-library"
    requires = ("draco/1.5.6", "glm/0.9.9.8", "highway/1.0.7", "nlohmann_json/3.11.3", "tinygltf/2.8.13", "vulkan-headers/1.3.268.0",
                "xxhash/0.8.2", "zlib/1.3.1", "zstd/1.5.5", "glslang/1.3.268.0", "spirv-cross/1.3.268.0")

    def set_version(self):
        header = (pathlib.Path(self.recipe_folder).resolve().parents[2] / "sdk/include/doppel/doppel.h").read_text(encoding="utf-8")
        self.version = re.search(r'^#define DPL_VERSION_TEXT "([^"]*)"', header, re.MULTILINE).group(1)

    def export_sources(self):
        for pattern in ("CMakeLists.txt", "LICENSE", "NOTICE", "sdk/*", "platform/*", "shaders/*", "tools/cmake/*", "tools/shaderpack/*"):
            copy(self, pattern, SOURCE, self.export_sources_folder)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables.update({"DOPPEL_RECONSTRUCTION": "OFF", "DOPPEL_TESTS": "OFF"})
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build(target="doppel_installed")

    def package(self):
        CMake(self).install(component="doppel_sdk")
        copy(self, "LICENSE", self.source_folder, str(pathlib.Path(self.package_folder) / "licenses"))
        copy(self, "NOTICE", self.source_folder, str(pathlib.Path(self.package_folder) / "licenses"))

    def package_info(self):
        self.cpp_info.libs = ["doppel"]
        self.cpp_info.set_property("cmake_file_name", "doppel")
        self.cpp_info.set_property("cmake_target_name", "doppel::doppel")
