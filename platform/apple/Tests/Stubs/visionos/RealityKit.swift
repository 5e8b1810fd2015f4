// SPDX-License-Identifier: Apache-2.0
// RealityKit: what DoppelRealityKit uses of it. Declarations only, compared with Apple's public documentation; see README.md.
import Metal

public protocol Component {}

@MainActor open class Entity {
    public struct ComponentSet {
        @MainActor public mutating func set<T: Component>(_ component: T) { fatalError() }
    }
    public required init() { fatalError() }
    public var components: ComponentSet { get { fatalError() } set {} }
}

public final class LowLevelBuffer: @unchecked Sendable {
    public struct Descriptor {
        public init(capacity: Int, sizeMultiple: Int = 1) { fatalError() }
    }
    public init(descriptor: Descriptor) throws { fatalError() }
    public var bytesUsed: Int { get { fatalError() } set {} }
    public func replace(using commandBuffer: any MTLCommandBuffer) -> any MTLBuffer { fatalError() }
}

public final class GaussianSplatResource: @unchecked Sendable {
    public enum SphericalHarmonicDegree: Sendable { case zero, first, second, third }
    public struct BufferDescriptor {
        public init(buffer: LowLevelBuffer, format: MTLAttributeFormat, stride: Int, offset: Int) { fatalError() }
    }
    public struct BufferResource {
        @MainActor public init(
            count: Int, position: BufferDescriptor, scale: BufferDescriptor, rotation: BufferDescriptor, opacity: BufferDescriptor,
            sphericalHarmonics: (BufferDescriptor, SphericalHarmonicDegree)
        ) throws { fatalError() }
    }
    public init(_ bufferResource: BufferResource) { fatalError() }
}

public struct GaussianSplatComponent: Component {
    public init(_ res: GaussianSplatResource) { fatalError() }
}
