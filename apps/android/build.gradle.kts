// SPDX-License-Identifier: Apache-2.0
// The demo app. Put an avatar into src/main/assets/avatar.glb.
plugins {
    alias(libs.plugins.android.application)
    alias(libs.plugins.kotlin.android)
}

android {
    namespace = "org.doppel.demo"
    compileSdk = libs.versions.compile.sdk.get().toInt()
    defaultConfig {
        applicationId = "org.doppel.demo"
        minSdk = libs.versions.min.sdk.get().toInt()
        targetSdk = libs.versions.compile.sdk.get().toInt()
        versionCode = 1
        versionName = "1.0.0-rc.1"
    }
    androidResources { noCompress += listOf("glb", "ply", "spz", "bvh") } // mapped, not copied
    sourceSets["main"].kotlin.srcDir("src/main/kotlin")
    compileOptions {
        sourceCompatibility = JavaVersion.VERSION_11
        targetCompatibility = JavaVersion.VERSION_11
    }
    kotlinOptions { jvmTarget = "11" }
    buildTypes {
        release {
            isMinifyEnabled = true
            signingConfig = signingConfigs["debug"] // so that it can be installed; replace it before you publish
        }
    }
}

dependencies {
    implementation(project(":doppel"))
}
