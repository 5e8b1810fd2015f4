// SPDX-License-Identifier: Apache-2.0
#if canImport(SwiftUI) && canImport(MetalKit) && (canImport(UIKit) || canImport(AppKit)) && !os(visionOS)
    import SwiftUI

    /// DoppelView for SwiftUI. The scene is kept alive by the caller.
    public struct AvatarCanvas {
        let stage: MetalStage
        let scene: any AvatarScene
        let transparent: Bool

        public init(stage: MetalStage, scene: any AvatarScene, transparent: Bool = false) {
            self.stage = stage
            self.scene = scene
            self.transparent = transparent
        }

        @MainActor private func makeView() -> DoppelView {
            let view = DoppelView(stage: stage, transparent: transparent)
            view.avatarScene = scene
            return view
        }
    }

    #if canImport(UIKit)
        extension AvatarCanvas: UIViewRepresentable {
            public func makeUIView(context: Context) -> DoppelView { makeView() }
            public func updateUIView(_ view: DoppelView, context: Context) { view.avatarScene = scene }
        }
    #else
        extension AvatarCanvas: NSViewRepresentable {
            public func makeNSView(context: Context) -> DoppelView { makeView() }
            public func updateNSView(_ view: DoppelView, context: Context) { view.avatarScene = scene }
        }
    #endif
#endif
