// SPDX-License-Identifier: Apache-2.0
// CompositorServices: what this package uses of it. Declarations only, checked against the public documentation; see README.md.
import ARKit
import Foundation
@_exported import Metal
import SwiftUI
import simd

public final class LayerRenderer {
    public enum State: Sendable { case paused, running, invalidated }
    public enum Layout: Sendable { case dedicated, shared, layered }

    public struct Clock {
        public struct Instant: Sendable {
            public static var epoch: Instant { fatalError() }
            public func duration(to other: Instant) -> Duration { fatalError() }
        }
        public init() {}
        public func wait(until deadline: Instant) {}
    }

    public struct Capabilities {
        public struct SupportedLayoutsOptions: OptionSet, Sendable {
            public let rawValue: UInt32
            public init(rawValue: UInt32) { self.rawValue = rawValue }
            public static let foveationEnabled = SupportedLayoutsOptions(rawValue: 1)
        }
        public func supportedLayouts(options: SupportedLayoutsOptions = []) -> [Layout] { fatalError() }
    }

    public struct Configuration {
        public var isFoveationEnabled: Bool
        public var colorFormat, depthFormat: MTLPixelFormat
        public var layout: Layout
    }

    public struct Frame {
        public struct Timing {
            public var optimalInputTime, presentationTime: Clock.Instant
        }
        public func startUpdate() {}
        public func endUpdate() {}
        public func predictTiming() -> Timing? { fatalError() }
        public func queryDrawable() -> Drawable? { fatalError() }
        public func startSubmission() {}
        public func endSubmission() {}
    }

    public struct Drawable {
        public struct View {
            public struct TextureMap {
                public var textureIndex, sliceIndex: Int
                public var viewport: MTLViewport
            }
            public var textureMap: TextureMap
            public var transform: simd_float4x4
        }
        public var frameTiming: Frame.Timing { fatalError() }
        public var deviceAnchor: DeviceAnchor? { get { fatalError() } nonmutating set {} }
        public var colorTextures: [any MTLTexture] { fatalError() }
        public var depthTextures: [any MTLTexture] { fatalError() }
        public var views: [View] { fatalError() }
        public func computeProjection(viewIndex: Int) -> simd_float4x4 { fatalError() }
        public func encodePresent(commandBuffer: any MTLCommandBuffer) {}
    }

    public var state: State { fatalError() }
    public func waitUntilRunning() {}
    public func queryNextFrame() -> Frame? { fatalError() }
}

public protocol CompositorLayerConfiguration {
    func makeConfiguration(capabilities: LayerRenderer.Capabilities, configuration: inout LayerRenderer.Configuration)
}

@MainActor public struct CompositorLayer: ImmersiveSpaceContent {
    public init(configuration: any CompositorLayerConfiguration, renderer: @escaping (LayerRenderer) -> Void) {}
}

/// Of the Objective-C runtime, which Linux lacks.
public func autoreleasepool<R>(invoking body: () throws -> R) rethrows -> R { try body() }
