// SPDX-License-Identifier: Apache-2.0
#if canImport(CompositorServices) && !os(macOS)
    import ARKit
    import CompositorServices
    import Doppel
    import Foundation
    import Metal
    import QuartzCore
    import simd

    /// What a CompositorRenderer shows. Called on its thread, once a frame.
    public protocol ImmersiveScene: Sendable {
        /// Poses avatars for a picture that is shown at displayTimeS (the clock of CACurrentMediaTime), and names those to draw. Where they
        /// stand in the room is their `Avatar.setTransform`.
        func avatars(displayTimeS: Double) -> [Avatar]
        /// The shadows on the floor of this picture, such as `contactShadow()` of the avatars. None, unless a scene says otherwise.
        func shadows(of avatars: [Avatar]) throws(DoppelError) -> [ContactShadow]
        /// A frame could not be drawn and is shown empty. Called once for each new text.
        func problem(_ error: DoppelError)
    }

    extension ImmersiveScene {
        public func shadows(of avatars: [Avatar]) throws(DoppelError) -> [ContactShadow] { [] }
    }

    /// The layer that CompositorRenderer draws into: no foveation, because Doppel's pictures have pixels of one size; both eyes as layers
    /// of one texture where the device offers it, else a texture for each.
    public struct AvatarLayerConfiguration: CompositorLayerConfiguration {
        public init() {}

        public func makeConfiguration(capabilities: LayerRenderer.Capabilities, configuration: inout LayerRenderer.Configuration) {
            configuration.isFoveationEnabled = false
            configuration.colorFormat = .bgra8Unorm_srgb
            configuration.depthFormat = .depth32Float
            configuration.layout = capabilities.supportedLayouts(options: []).contains(.layered) ? .layered : .dedicated
        }
    }

    /// Draws avatars in an immersive space of visionOS, with depth for reprojection.
    public final class CompositorRenderer: Sendable {
        public let stage: MetalStage
        private let scene: any ImmersiveScene
        private let session = ARKitSession()
        private let head = WorldTrackingProvider()

        public init(stage: MetalStage, scene: any ImmersiveScene) {
            self.stage = stage
            self.scene = scene
        }

        /// Draws until the layer is invalidated, on a thread of its own. Call it in the closure of CompositorLayer.
        public func start(_ layer: LayerRenderer) {
            Task { [self] in
                do { try await session.run([head]) } catch { scene.problem(DoppelError(.unsupported, "no tracking of the head: \(error)")) }
            }
            let lent = Lent(layer: layer)
            let thread = Thread { [self] in
                var loop = Loop(stage: stage, scene: scene, head: head)
                loop.run(lent.layer)
            }
            thread.name = "Doppel compositor"
            thread.qualityOfService = .userInteractive
            thread.start()
        }

        private struct Lent: @unchecked Sendable { let layer: LayerRenderer }  // handed over to the thread
    }

    /// The frame loop.
    private struct Loop {
        let stage: MetalStage
        let scene: any ImmersiveScene
        let head: WorldTrackingProvider
        var lastProblem: DoppelError?

        mutating func run(_ layer: LayerRenderer) {
            while layer.state != .invalidated {
                if layer.state == .paused {
                    layer.waitUntilRunning()
                } else {
                    autoreleasepool { drawFrame(layer) }
                }
            }
        }

        private mutating func drawFrame(_ layer: LayerRenderer) {
            guard let frame = layer.queryNextFrame() else { return }
            frame.startUpdate()
            frame.endUpdate()
            guard let timing = frame.predictTiming() else { return }
            LayerRenderer.Clock().wait(until: timing.optimalInputTime)
            guard let drawable = frame.queryDrawable() else { return }
            frame.startSubmission()
            let shownS = LayerRenderer.Clock.Instant.epoch.duration(to: drawable.frameTiming.presentationTime).seconds
            let anchor = head.queryDeviceAnchor(atTimestamp: shownS)
            drawable.deviceAnchor = anchor
            let passes = DrawablePass.all(of: drawable)
            do {
                // Where the head is not known, the picture stays empty.
                let avatars = anchor == nil ? [] : scene.avatars(displayTimeS: shownS)
                let originFromHead = RigidPose(anchor?.originFromAnchorTransform ?? matrix_identity_float4x4)
                try submit(drawable, passes, avatars, originFromHead)
                lastProblem = nil
            } catch {
                if error != lastProblem { scene.problem(error) }
                lastProblem = error
            }
            frame.endSubmission()
        }

        /// The compositor waits for a picture of every frame, so one is presented whatever happens.
        private func submit(
            _ drawable: LayerRenderer.Drawable, _ passes: [DrawablePass], _ avatars: [Avatar], _ originFromHead: RigidPose
        ) throws(DoppelError) {
            let frame: MetalFrame?
            let depths: [Camera.StoredDepth]
            let cameras: [Camera]
            let shadows: [ContactShadow]
            do {
                for pass in passes { try stage.make(pass.kind) }
                let seen = try views(of: drawable, originFromHead)
                depths = seen.map(\.depth)
                cameras = seen.map(\.camera)
                shadows = try scene.shadows(of: avatars)
                frame = try stage.begin(avatars, from: cameras, nowS: CACurrentMediaTime(), waitS: 0.1)
            } catch {
                presentEmpty(drawable, passes)
                throw error
            }
            guard let frame else { return presentEmpty(drawable, passes) }
            defer {
                drawable.encodePresent(commandBuffer: frame.commands)
                stage.commit(frame)
            }
            for pass in passes {
                guard let encoder = frame.commands.makeRenderCommandEncoder(descriptor: pass.descriptor) else { continue }
                defer { encoder.endEncoding() }
                let seen = pass.kind.layers > 0 ? cameras : [cameras[pass.view]]
                try stage.drawShadows(shadows, from: seen, into: encoder, pass: pass.kind, x: pass.x, y: pass.y)
                try stage.compose(frame, into: encoder, pass: pass.kind, view: pass.view, x: pass.x, y: pass.y, depth: depths[pass.view])
            }
        }

        private func views(
            of drawable: LayerRenderer.Drawable, _ originFromHead: RigidPose
        ) throws(DoppelError) -> [(camera: Camera, depth: Camera.StoredDepth)] {
            var seen: [(camera: Camera, depth: Camera.StoredDepth)] = []
            for (index, view) in drawable.views.enumerated() {
                let place = view.textureMap.viewport
                seen.append(
                    try Camera.from(
                        projection: drawable.computeProjection(viewIndex: index).floats, pose: originFromHead * RigidPose(view.transform),
                        widthPx: Int(place.width), heightPx: Int(place.height)))
            }
            return seen
        }

        private func presentEmpty(_ drawable: LayerRenderer.Drawable, _ passes: [DrawablePass]) {
            guard let commands = stage.emptyCommands() else { return }
            for pass in passes { commands.makeRenderCommandEncoder(descriptor: pass.descriptor)?.endEncoding() }
            drawable.encodePresent(commandBuffer: commands)
            commands.commit()
        }
    }

    extension Duration {
        fileprivate var seconds: Double { Double(components.seconds) + Double(components.attoseconds) * 1e-18 }
    }
#endif
