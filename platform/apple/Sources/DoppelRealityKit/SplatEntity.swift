// SPDX-License-Identifier: Apache-2.0
#if canImport(RealityKit)
    import Doppel
    import DoppelUI
    import Metal
    import RealityKit

    /// An avatar as an entity that RealityKit draws, with a `GaussianSplatComponent`, which needs the SDKs of 2026 (Xcode 27). Doppel
    /// writes the posed splats into RealityKit's buffer on the GPU; RealityKit sorts and draws them, with its own low-pass. No device has
    /// run it: its types are checked against declarations of our own. Experimental.
    ///
    ///     let person = try SplatEntity(avatar, stage: stage, shDegree: 1)
    ///     content.add(person.entity)
    ///     // each frame, after the pose is set:
    ///     guard let frame = try stage.begin([], from: [], nowS: nowS) else { return }
    ///     try person.write(in: frame)
    ///     stage.commit(frame)
    @available(iOS 27, macOS 27, visionOS 27, *)
    @MainActor public final class SplatEntity {
        /// Splats are in the world, so it stays at the origin: `Avatar.setTransform` places the person.
        public let entity = Entity()
        private let avatar: Avatar
        private let stage: MetalStage
        private let buffer: LowLevelBuffer
        private let elements: [BufferElement<SplatProperty>]
        private var options: SplatOptions

        /// stage: on the system's default device, which RealityKit uses too. splatBudget: most splats, as RealityKit has a limit of its
        /// own; 0: all of them. shDegree: 0 to 3, how much of the colour changes with the direction. Throws what Doppel or RealityKit
        /// throw.
        public init(_ avatar: Avatar, stage: MetalStage, splatBudget: Int = 0, shDegree: Int = 0) throws {
            guard let degree = Self.degrees.indices.contains(shDegree) ? Self.degrees[shDegree] : nil else {
                throw DoppelError(.invalidArgument, "SH of degree \(shDegree); 0 to 3 are possible")
            }
            self.avatar = avatar
            self.stage = stage
            options = SplatOptions(splatBudget: splatBudget, shDegree: shDegree)
            let count = try stage.splatCount(of: avatar, options), stride = 44 + 12 * (shDegree + 1) * (shDegree + 1)
            let bytes = (count * stride + 15) / 16 * 16
            buffer = try LowLevelBuffer(descriptor: .init(capacity: bytes, sizeMultiple: 16))
            buffer.bytesUsed = bytes
            elements = [
                BufferElement(.position, offsetBytes: 0, strideBytes: stride),
                BufferElement(.scale, offsetBytes: 12, strideBytes: stride),
                BufferElement(.rotationWXYZ, offsetBytes: 24, strideBytes: stride),
                BufferElement(.opacity, offsetBytes: 40, strideBytes: stride),
                BufferElement(.harmonics, offsetBytes: 44, strideBytes: stride),
            ]
            let buffer = buffer
            func place(_ format: MTLAttributeFormat, _ offset: Int) -> GaussianSplatResource.BufferDescriptor {
                GaussianSplatResource.BufferDescriptor(buffer: buffer, format: format, stride: stride, offset: offset)
            }
            let splats = try GaussianSplatResource.BufferResource(
                count: count, position: place(.float3, 0), scale: place(.float3, 12), rotation: place(.float4, 24),
                opacity: place(.float, 40), sphericalHarmonics: (place(.float3, 44), degree))
            entity.components.set(GaussianSplatComponent(GaussianSplatResource(splats)))
        }

        /// Writes the avatar's current pose, by the frame's commands, which RealityKit waits for. eye: where the viewer is, metres, world;
        /// without it splats that should show their outside alone show both sides.
        public func write(in frame: MetalFrame, eye: SIMD3<Float>? = nil) throws(DoppelError) {
            options.eye = eye
            try stage.writeSplats(of: avatar, elements, into: buffer.replace(using: frame.commands), in: frame, options)
        }

        private static let degrees: [GaussianSplatResource.SphericalHarmonicDegree] = [.zero, .first, .second, .third]
    }
#endif
