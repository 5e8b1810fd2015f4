// SPDX-License-Identifier: Apache-2.0
plugins {
    alias(libs.plugins.android.application) apply false
    alias(libs.plugins.android.library) apply false
    alias(libs.plugins.kotlin.android) apply false
}

// For the modules with native code.
val repository by extra(rootDir.resolve("../.."))
val cmakeArguments by extra(
    listOf(
        "-DANDROID_STL=c++_static",
        "-DDOPPEL_RECONSTRUCTION=OFF",
        "-DDOPPEL_TESTS=OFF",
        "-DDOPPEL_SHADERPACK=$repository/build/release/tools/shaderpack/shaderpack"
    )
)
