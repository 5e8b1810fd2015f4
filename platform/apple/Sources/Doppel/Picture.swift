// SPDX-License-Identifier: Apache-2.0
import CDoppel

/// Pixels in memory that drawing writes; use it again for the next frame. Not for two threads at once.
public final class Picture {
    public let widthPx, heightPx: Int
    /// RGBA, 8 bits each, top row first.
    public let rgba: UnsafeMutableBufferPointer<UInt8>
    /// View z in metres, 0 where nothing is drawn; empty if it was not asked for.
    public let depthM: UnsafeMutableBufferPointer<Float>

    public init(widthPx: Int, heightPx: Int, withDepth: Bool = false) throws(DoppelError) {
        let sides = 1...Int(DPL_MAX_IMAGE_SIDE_PX)
        if !sides.contains(widthPx) || !sides.contains(heightPx) {
            throw DoppelError(.invalidArgument, "a picture has 1 to \(DPL_MAX_IMAGE_SIDE_PX) pixels a side, not \(widthPx) x \(heightPx)")
        }
        self.widthPx = widthPx
        self.heightPx = heightPx
        rgba = .allocate(capacity: 4 * widthPx * heightPx)
        rgba.initialize(repeating: 0)
        depthM = .allocate(capacity: withDepth ? widthPx * heightPx : 0)
        depthM.initialize(repeating: 0)
    }

    deinit {
        rgba.deallocate()
        depthM.deallocate()
    }

    /// The pixel in column x of row y.
    public subscript(x: Int, y: Int) -> SIMD4<UInt8> {
        precondition((0..<widthPx).contains(x) && (0..<heightPx).contains(y), "no pixel (\(x), \(y)) in \(widthPx) x \(heightPx)")
        let at = 4 * (y * widthPx + x)
        return SIMD4(rgba[at], rgba[at + 1], rgba[at + 2], rgba[at + 3])
    }

    func image(straightAlpha: Bool) -> DplImage {
        var image = DplImage.sized
        image.flags = straightAlpha ? UInt32(DPL_IMAGE_STRAIGHT_ALPHA.rawValue) : 0
        image.rgba = rgba.baseAddress
        image.rgbaBytes = rgba.count
        if !depthM.isEmpty {
            image.depthM = depthM.baseAddress
            image.depthCount = depthM.count
        }
        return image
    }
}

extension DoppelContext {
    /// Draws avatars in their current poses and waits for the pixels: one or two cameras, and a picture of the same size for each. Colour
    /// is premultiplied, or straight. Apps that draw every frame use DoppelUI, which copies no pixels.
    public func render(
        _ avatars: [Avatar], from cameras: [Camera], into pictures: [Picture], straightAlpha: Bool = false
    ) throws(DoppelError) {
        if cameras.count != pictures.count {
            throw DoppelError(.invalidArgument, "\(cameras.count) cameras need as many pictures, not \(pictures.count)")
        }
        for (camera, picture) in zip(cameras, pictures) where camera.widthPx != picture.widthPx || camera.heightPx != picture.heightPx {
            throw DoppelError(
                .invalidArgument,
                "a camera of \(camera.widthPx) x \(camera.heightPx) needs a picture of that size, "
                    + "not \(picture.widthPx) x \(picture.heightPx)")
        }
        let handles = avatars.map { Optional($0.handle.raw) }
        let views = cameras.map(\.raw)
        let images = pictures.map { $0.image(straightAlpha: straightAlpha) }
        let result = withExtendedLifetime((avatars, pictures)) {
            dplRenderTogether(handle.raw, handles, UInt32(handles.count), views, UInt32(views.count), images)
        }
        try check(result)
    }
}
