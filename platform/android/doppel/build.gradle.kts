// SPDX-License-Identifier: Apache-2.0
// The library: doppel-release.aar with libdoppel.so, libdoppel_jni.so and the Kotlin API.
plugins {
    alias(libs.plugins.android.library)
    alias(libs.plugins.kotlin.android)
}

val repository: File by rootProject.extra
val cmakeArguments: List<String> by rootProject.extra

android {
    namespace = "org.doppel"
    compileSdk = libs.versions.compile.sdk.get().toInt()
    ndkVersion = libs.versions.ndk.get()
    defaultConfig {
        minSdk = libs.versions.min.sdk.get().toInt()
        consumerProguardFiles("consumer-rules.pro")
        ndk { abiFilters += listOf("arm64-v8a", "x86_64") }
        externalNativeBuild {
            cmake {
                targets += listOf("doppel", "doppel_jni")
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
    sourceSets["main"].kotlin.srcDir("src/main/kotlin")
    compileOptions {
        sourceCompatibility = JavaVersion.VERSION_11
        targetCompatibility = JavaVersion.VERSION_11
    }
    kotlinOptions { jvmTarget = "11" }
}
