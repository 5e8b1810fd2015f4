// swift-tools-version: 6.0
// SPDX-License-Identifier: Apache-2.0
// The Swift package Doppel. On Apple's platforms the C library is CDoppel.xcframework, which make-xcframework builds. On Linux it is an
// installed libdoppel, or one that -Xcc -I and -Xlinker -L name (tools/prove-swift).
import PackageDescription

#if os(Linux)
let library = Target.systemLibrary(name: "CDoppel", path: "Sources/CDoppel", pkgConfig: "doppel")
let linkerSettings: [LinkerSetting] = []
#else
let library = Target.binaryTarget(name: "CDoppel", path: "build/CDoppel.xcframework")
let linkerSettings: [LinkerSetting] = [.linkedLibrary("c++"), .linkedLibrary("z"), .linkedFramework("Metal"),
    .linkedFramework("Foundation")]
#endif

let package = Package(
    name: "Doppel",
    platforms: [.iOS(.v16), .macOS(.v13), .visionOS(.v2)],
    products: [
        .library(name: "Doppel", targets: ["Doppel"]),
        .library(name: "DoppelUI", targets: ["DoppelUI"]),
        .library(name: "DoppelRealityKit", targets: ["DoppelRealityKit"]),  // apart: it needs Xcode 27
    ],
    targets: [
        library,
        .target(
            name: "Doppel", dependencies: ["CDoppel"], resources: [.copy("PrivacyInfo.xcprivacy")], linkerSettings: linkerSettings),
        .target(name: "DoppelUI", dependencies: ["Doppel"]),
        .target(name: "DoppelRealityKit", dependencies: ["Doppel", "DoppelUI"]),
        .testTarget(name: "DoppelTests", dependencies: ["Doppel", "DoppelUI"]),
    ],
    swiftLanguageModes: [.v6]
)
