// SPDX-License-Identifier: Apache-2.0
// The app for Quest and other headsets that run Android. Put an avatar into src/main/assets, as avatar.glb.
plugins {
    alias(libs.plugins.android.application)
}

val repository: File by rootProject.extra
val cmakeArguments: List<String> by rootProject.extra

android {
    namespace = "org.doppel.quest"
    compileSdk = libs.versions.compile.sdk.get().toInt()
    ndkVersion = libs.versions.ndk.get()
    defaultConfig {
        applicationId = "org.doppel.quest"
        minSdk = libs.versions.min.sdk.get().toInt()
        targetSdk = 32 // Meta's store asks for at most this
        versionCode = 1
        versionName = "1.0.0-rc.1"
        ndk { abiFilters += "arm64-v8a" }
        externalNativeBuild {
            cmake {
                targets += listOf("doppel", "doppel_quest")
                arguments += cmakeArguments
            }
        }
    }
    externalNativeBuild {
        cmake {
            path = repository.resolve("CMakeLists.txt")
            version = libs.versions.cmake.get()
        }
    }
    buildFeatures { prefab = true } // CMake finds the loader's package OpenXR
    androidResources { noCompress += listOf("glb", "ply", "spz") }
}

dependencies {
    implementation(libs.openxr.loader)
}
