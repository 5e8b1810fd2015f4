// SPDX-License-Identifier: Apache-2.0
import CDoppel

/// The shadow by which feet stand on a floor, as a picture of alpha; see `DplContactShadow`.
public struct ContactShadow: Sendable, Equatable {
    /// Pixels of a side.
    public static let sidePx = Int(DPL_CONTACT_SHADOW_PX)
    /// Row by row; 255: black.
    public let alpha: [UInt8]
    /// The largest alpha; 0: nothing is near the floor.
    public let darkest: Int
    /// Outer corner of the first pixel, and from it along the first row and along the first column to the ends of the picture. Metres of
    /// the world.
    public let corner, across, along: SIMD3<Float>
}

/// What the posed surface tells, on the CPU and whatever draws it.
extension Avatar {
    /// A part of an avatar: its body, a garment, its hair.
    public struct Layer: Sendable, Equatable {
        public let name: String
        /// "body", "garment" or "hair".
        public let role: String
        public let triangleCount: Int
        public let isHidden: Bool
    }

    public func layer(_ index: Int) throws(DoppelError) -> Layer {
        let number = try c(index)
        let c = try filled(DplLayerInfo.sized) { dplGetLayerInfo(handle.raw, number, $0) }
        return Layer(
            name: String(cString: c.name), role: String(cString: c.role), triangleCount: Int(c.triangleCount), isHidden: c.hidden != 0)
    }

    /// Hides a layer, or shows it again. `.unsupported`, with a sentence: no splats lie below it, as below most clothes of a scan. See
    /// `dplHideLayer`.
    public func hide(layer: Int, _ hidden: Bool = true) throws(DoppelError) {
        try check(dplHideLayer(handle.raw, try c(layer), hidden ? DPL_TRUE : DPL_FALSE))
    }

    /// What a ray meets first.
    public struct Pick: Sendable, Equatable {
        /// Index among the avatars that were asked.
        public let avatar: Int
        /// Of that avatar. An avatar without clothes as layers is one layer, its body.
        public let layer: Int
        /// The joint with the largest weight there.
        public let joint: Int
        /// Metres of the world. The normal is on the side that the ray comes from.
        public let distanceM: Float
        public let point, normal: SIMD3<Float>
    }

    /// What a ray of the world meets first of some avatars; nil: nothing. direction: of any length above 0. See `dplPick`.
    public static func pick(_ avatars: [Avatar], origin: SIMD3<Float>, direction: SIMD3<Float>) throws(DoppelError) -> Pick? {
        let handles: [DplAvatar?] = avatars.map { $0.handle.raw }
        let count = try c(handles.count)
        let from = [origin.x, origin.y, origin.z]
        let along = [direction.x, direction.y, direction.z]
        let p = try filled(DplPick.sized) { dplPick(handles, count, from, along, $0) }
        if p.hit == 0 { return nil }
        return Pick(
            avatar: Int(p.avatar), layer: Int(p.layer), joint: Int(p.joint), distanceM: p.distanceM,
            point: SIMD3(p.point.0, p.point.1, p.point.2), normal: SIMD3(p.normal.0, p.normal.1, p.normal.2))
    }

    /// The shadow on a floor. floorM: height of the app's floor, metres; nil: where the avatar stands at rest. See `dplGetContactShadow`.
    public func contactShadow(floorM: Float? = nil) throws(DoppelError) -> ContactShadow {
        var alpha = [UInt8](repeating: 0, count: ContactShadow.sidePx * ContactShadow.sidePx)
        var place = DplContactShadow.sized
        let count = alpha.count
        if let floorM {
            try check(withUnsafePointer(to: floorM) { dplGetContactShadow(handle.raw, $0, &alpha, count, &place) })
        } else {
            try check(dplGetContactShadow(handle.raw, nil, &alpha, count, &place))
        }
        return ContactShadow(
            alpha: alpha, darkest: Int(place.darkest), corner: SIMD3(place.corner.0, place.corner.1, place.corner.2),
            across: SIMD3(place.across.0, place.across.1, place.across.2), along: SIMD3(place.along.0, place.along.1, place.along.2))
    }
}
