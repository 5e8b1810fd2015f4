// SPDX-License-Identifier: Apache-2.0
import CDoppel
import Foundation

/// A pinhole camera, as `DplCamera`: x right, y down, looks along +z, pixels from the top left corner.
public struct Camera: @unchecked Sendable {  // the pointer to a scene's depth stays NULL
    public var raw: DplCamera

    /// The camera of a view that is given by four angles from straight ahead: left, right, top, bottom, radians; usually left and bottom
    /// are negative. pose: of the eye in the world, which looks along -z with y up.
    public init(pose: RigidPose, anglesRad: SIMD4<Float>, widthPx: Int, heightPx: Int) throws(DoppelError) {
        raw = .sized
        let angles = [anglesRad.x, anglesRad.y, anglesRad.z, anglesRad.w]
        try check(dplCameraFromAngles(pose.quaternion, pose.translation, angles, try c(widthPx), try c(heightPx), &raw))
    }

    /// A camera with a vertical field of view, radians.
    public init(pose: RigidPose, fovYRad: Float, widthPx: Int, heightPx: Int) throws(DoppelError) {
        let up = fovYRad / 2
        let right = atan(tan(up) * Float(widthPx) / Float(max(heightPx, 1)))
        try self.init(pose: pose, anglesRad: SIMD4(-right, right, up, -up), widthPx: widthPx, heightPx: heightPx)
    }

    /// How a depth buffer stores depth: scale + offset / z, as in `DplMetalSceneDepth`.
    public struct StoredDepth: Sendable, Equatable {
        public let scale, offset: Float

        public init(scale: Float, offset: Float) {
            self.scale = scale
            self.offset = offset
        }
    }

    /// The camera of a view that is given by a projection matrix for Metal's clip space, 16 floats, column-major, and how that matrix
    /// stores depth.
    public static func from(
        projection: [Float], pose: RigidPose, widthPx: Int, heightPx: Int
    ) throws(DoppelError) -> (camera: Camera, depth: StoredDepth) {
        if projection.count != 16 { throw DoppelError(.invalidArgument, "a projection has 16 floats, not \(projection.count)") }
        var raw = DplCamera.sized
        var depth: [Float] = [0, 0]
        try check(
            dplCameraFromProjection(
                pose.quaternion, pose.translation, projection, DPL_CLIP_DEPTH_ZERO_TO_ONE, try c(widthPx), try c(heightPx), &raw, &depth))
        return (Camera(raw: raw), StoredDepth(scale: depth[0], offset: depth[1]))
    }

    init(raw: DplCamera) { self.raw = raw }

    public var widthPx: Int { Int(raw.widthPx) }
    public var heightPx: Int { Int(raw.heightPx) }
}
