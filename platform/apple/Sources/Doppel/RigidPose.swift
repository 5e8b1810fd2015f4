// SPDX-License-Identifier: Apache-2.0
import Foundation

/// Where something is and how it is turned: outer space from inner space. Right-handed, +Y up, metres; rotation is a unit quaternion
/// x, y, z, w, as in ARKit and `simd_quatf.vector`.
public struct RigidPose: Sendable, Equatable {
    public var rotation: SIMD4<Float>
    public var position: SIMD3<Float>

    public init(rotation: SIMD4<Float> = SIMD4(0, 0, 0, 1), position: SIMD3<Float> = .zero) {
        self.rotation = rotation
        self.position = position
    }

    /// Turned about +Y, which turns +Z towards +X.
    public init(yawRad: Float, position: SIMD3<Float> = .zero) {
        self.init(rotation: SIMD4(0, sin(yawRad / 2), 0, cos(yawRad / 2)), position: position)
    }

    /// Outer from inner: `worldFromEye = worldFromHead * headFromEye`.
    public static func * (outer: RigidPose, inner: RigidPose) -> RigidPose {
        RigidPose(rotation: product(outer.rotation, inner.rotation), position: outer.position + turned(inner.position, by: outer.rotation))
    }

    public var inverse: RigidPose {
        let back = rotation * SIMD4(-1, -1, -1, 1)
        return RigidPose(rotation: back, position: -turned(position, by: back))
    }

    /// The matrix [scale · rotation, position], row by row.
    func rows(scale: Float) -> [Float] {
        let x = turned(SIMD3(scale, 0, 0), by: rotation)
        let y = turned(SIMD3(0, scale, 0), by: rotation)
        let z = turned(SIMD3(0, 0, scale), by: rotation)
        return [x.x, y.x, z.x, position.x, x.y, y.y, z.y, position.y, x.z, y.z, z.z, position.z]
    }

    var quaternion: [Float] { [rotation.x, rotation.y, rotation.z, rotation.w] }
    var translation: [Float] { [position.x, position.y, position.z] }
}

private func cross(_ a: SIMD3<Float>, _ b: SIMD3<Float>) -> SIMD3<Float> {
    SIMD3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

private func product(_ a: SIMD4<Float>, _ b: SIMD4<Float>) -> SIMD4<Float> {
    let u = SIMD3(a.x, a.y, a.z), v = SIMD3(b.x, b.y, b.z)
    let xyz = v * a.w + u * b.w + cross(u, v)
    return SIMD4(xyz, a.w * b.w - (u * v).sum())
}

private func turned(_ p: SIMD3<Float>, by q: SIMD4<Float>) -> SIMD3<Float> {
    let u = SIMD3(q.x, q.y, q.z)
    let t = cross(u, p) * 2
    return p + t * q.w + cross(u, t)
}

/// A camera that circles a point, for fingers and mice.
public struct Orbit: Sendable, Equatable {
    public var target: SIMD3<Float>
    public var distanceM: Float
    /// About +Y; 0 looks at the front of an avatar.
    public var azimuthRad: Float = 0
    /// Above the horizon.
    public var elevationRad: Float = 0

    public init(target: SIMD3<Float>, distanceM: Float) {
        self.target = target
        self.distanceM = distanceM
    }

    /// Sees a whole avatar through a vertical field of view.
    public init(around info: Avatar.Info, fovYRad: Float) {
        let size = info.restMax - info.restMin
        self.init(target: (info.restMin + info.restMax) / 2, distanceM: max(0.6 * max(size.x, size.y) / tan(fovYRad / 2), 0.3))
    }

    /// Turns by a finger's way, as shares of the view's height, and keeps the camera above and below within 85 degrees.
    public mutating func drag(x: Float, y: Float) {
        azimuthRad -= x * .pi
        elevationRad = min(max(elevationRad + y * .pi, -1.48), 1.48)
    }

    /// Comes nearer by a factor above 1; stays beyond the near plane.
    public mutating func zoom(by factor: Float) {
        if factor.isFinite && factor > 0 { distanceM = min(max(distanceM / factor, 0.2), 50) }
    }

    /// Of an eye that looks along -z.
    public var eye: RigidPose {
        let yaw = RigidPose(yawRad: azimuthRad, position: target)
        let pitch = RigidPose(rotation: SIMD4(sin(-elevationRad / 2), 0, 0, cos(elevationRad / 2)))
        return yaw * pitch * RigidPose(position: SIMD3(0, 0, distanceM))
    }
}
