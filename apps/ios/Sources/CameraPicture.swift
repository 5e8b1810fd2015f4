// SPDX-License-Identifier: Apache-2.0
import ARKit
import RealityKit
import SwiftUI

/// What the phone's camera sees, below the avatar. RealityKit draws it; the avatar's view above it is transparent.
struct CameraPicture: UIViewRepresentable {
    let studio: Studio

    func makeUIView(context: Context) -> ARView {
        let view = ARView(frame: .zero, cameraMode: .ar, automaticallyConfigureSession: false)
        view.session = studio.room.session
        return view
    }

    func updateUIView(_ view: ARView, context: Context) {}
}
