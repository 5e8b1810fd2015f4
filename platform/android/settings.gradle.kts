// SPDX-License-Identifier: Apache-2.0
// Open this folder in Android Studio. README.md says what to run once before.
pluginManagement {
    repositories {
        google()
        mavenCentral()
        gradlePluginPortal()
    }
}
dependencyResolutionManagement {
    repositoriesMode.set(RepositoriesMode.FAIL_ON_PROJECT_REPOS)
    repositories {
        google()
        mavenCentral()
    }
}
rootProject.name = "doppel-android"
include(":doppel", ":demo", ":quest")
project(":demo").projectDir = file("../../apps/android")
project(":quest").projectDir = file("../../apps/xr/android")
