// SPDX-License-Identifier: Apache-2.0
import CDoppel

/// A property of a splat or a vertex that a buffer can hold; numbers, units and frames: `DplSplatProperty`, `DplVertexProperty`.
public protocol BufferProperty: RawRepresentable, Sendable where RawValue == UInt32 {}

public enum SplatProperty: UInt32, BufferProperty {
    case position = 0
    case rotation, scale, covariance, opacity, colour
    /// Spherical harmonics.
    case harmonics
    /// As `rotation`, w first.
    case rotationWXYZ
}

public enum VertexProperty: UInt32, BufferProperty {
    case position = 0
    case normal
}

/// Where one property lies in a buffer; see `DplBufferElement`.
public struct BufferElement<Property: BufferProperty>: Sendable {
    public var property: Property
    /// Halves in place of floats. Numbers beyond 65504 become 65504.
    public var isHalf: Bool
    /// From the start of the buffer to the first splat's or vertex's.
    public var offsetBytes: Int
    /// From one to the next; 0: without gaps.
    public var strideBytes: Int

    public init(_ property: Property, offsetBytes: Int = 0, strideBytes: Int = 0, isHalf: Bool = false) {
        self.property = property
        self.isHalf = isHalf
        self.offsetBytes = offsetBytes
        self.strideBytes = strideBytes
    }

    func raw() throws(DoppelError) -> DplBufferElement {
        guard let offset = UInt64(exactly: offsetBytes), let stride = UInt64(exactly: strideBytes) else {
            throw DoppelError(.invalidArgument, "an offset of \(offsetBytes) and a stride of \(strideBytes) bytes; neither may be negative")
        }
        var out = DplBufferElement.sized
        out.property = property.rawValue
        out.number = isHalf ? DPL_NUMBER_HALF : DPL_NUMBER_FLOAT
        out.offsetBytes = offset
        out.strideBytes = stride
        return out
    }
}

/// Which splats are written, and for whom; see `DplSplatOptions`.
public struct SplatOptions: Sendable {
    /// Level of detail: most splats; 0: all of them.
    public var splatBudget: Int
    /// Where the viewer is, metres, world. Without it splats show both sides.
    public var eye: SIMD3<Float>?
    /// Of `.harmonics`, 0 to 3.
    public var shDegree: Int

    public init(splatBudget: Int = 0, eye: SIMD3<Float>? = nil, shDegree: Int = 0) {
        self.splatBudget = splatBudget
        self.eye = eye
        self.shDegree = shDegree
    }

    /// Calls a C function that takes them and fills a `DplWritten`.
    package func written(
        by body: (UnsafePointer<DplSplatOptions>, UnsafeMutablePointer<DplWritten>) -> DplResult
    ) throws(DoppelError) -> Written {
        var raw = DplSplatOptions.sized
        raw.splatBudget = try c(splatBudget)
        raw.shDegree = try c(shDegree)
        let eye = eye.map { [$0.x, $0.y, $0.z] } ?? []
        return Written(
            try filled(DplWritten.sized) { written in
                eye.withUnsafeBufferPointer {
                    raw.eye = eye.isEmpty ? nil : $0.baseAddress
                    return body(&raw, written)
                }
            })
    }
}

/// Elements as the C interface takes them, valid during `body`.
package func withElements<Property>(
    _ elements: [BufferElement<Property>], _ body: (UnsafePointer<DplBufferElement>?, UInt32) throws(DoppelError) -> Written
) throws(DoppelError) -> Written {
    var raw: [DplBufferElement] = []
    for element in elements { raw.append(try element.raw()) }
    let count = try c(raw.count)
    // A typed error does not pass through withUnsafeBufferPointer in Swift 6.0.
    let result: Result<Written, DoppelError> = raw.withUnsafeBufferPointer {
        do throws(DoppelError) {
            return .success(try body($0.baseAddress, count))
        } catch {
            return .failure(error)
        }
    }
    return try result.get()
}

/// What was written.
public struct Written: Sendable, Equatable {
    /// Splats or vertices.
    public let count: Int
    /// Numbers that were too large for a half; of writes by a GPU 0.
    public let saturated: Int

    init(_ raw: DplWritten) {
        count = Int(raw.count)
        saturated = Int(raw.saturated)
    }
}

/// Posed splats and vertices in memory of the app, for engines that draw them themselves. Experimental, as in C.
extension Avatar {
    /// How many splats `writeSplats` writes.
    public func splatCount(_ options: SplatOptions = SplatOptions()) throws(DoppelError) -> Int {
        try write(options, nil).count
    }

    /// Writes the splats of the current pose. `.unsupported`: the context draws on a GPU, which keeps them. See `dplWriteSplats`.
    @discardableResult
    public func writeSplats(
        _ elements: [BufferElement<SplatProperty>], into bytes: UnsafeMutableRawBufferPointer, _ options: SplatOptions = SplatOptions()
    ) throws(DoppelError) -> Written {
        try withBuffer(elements, bytes) { buffer throws(DoppelError) in try self.write(options, buffer) }
    }

    /// Writes the vertices of the current pose, whatever draws the avatar. See `dplWriteMesh`.
    @discardableResult
    public func writeMesh(
        _ elements: [BufferElement<VertexProperty>], into bytes: UnsafeMutableRawBufferPointer
    ) throws(DoppelError) -> Written {
        try withBuffer(elements, bytes) { buffer throws(DoppelError) in
            Written(try filled(DplWritten.sized) { dplWriteMesh(self.handle.raw, buffer, $0) })
        }
    }

    private func write(_ options: SplatOptions, _ buffer: UnsafePointer<DplBuffer>?) throws(DoppelError) -> Written {
        try options.written { dplWriteSplats(handle.raw, $0, buffer, $1) }
    }

    private func withBuffer<Property>(
        _ elements: [BufferElement<Property>], _ bytes: UnsafeMutableRawBufferPointer,
        _ body: (UnsafePointer<DplBuffer>) throws(DoppelError) -> Written
    ) throws(DoppelError) -> Written {
        try withElements(elements) { raw, count throws(DoppelError) in
            var buffer = DplBuffer.sized
            buffer.elements = raw
            buffer.elementCount = count
            buffer.data = bytes.baseAddress
            buffer.dataBytes = UInt64(bytes.count)
            return try body(&buffer)
        }
    }
}
