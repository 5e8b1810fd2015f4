// SPDX-License-Identifier: Apache-2.0
import CDoppel
import Foundation

/// What went wrong: the code of the C interface, and the library's sentence for a human.
public struct DoppelError: Error, Equatable, Sendable, CustomStringConvertible, LocalizedError {
    /// The codes of `DplResult`.
    public enum Code: Int32, Sendable {
        case invalidArgument = -1
        case notFound = -2
        case corruptData = -3
        case version = -4
        case unsupported = -5
        case outOfMemory = -6
        case io = -7
        case device = -8
        case `internal` = -9
    }

    public let code: Code
    public let message: String

    public init(_ code: Code, _ message: String) {
        self.code = code
        self.message = message
    }

    /// The error of a C call that has just returned `result` on this thread.
    public init(_ result: DplResult) {
        let text = String(cString: dplGetLastError())
        self.init(Code(rawValue: result.rawValue) ?? .internal, text.isEmpty ? String(cString: dplGetResultName(result)) : text)
    }

    public var description: String { message }
    public var errorDescription: String? { message }
}

/// Throws the error of a C call that has just returned on this thread.
public func check(_ result: DplResult) throws(DoppelError) {
    if result != DPL_OK { throw DoppelError(result) }
}

/// Calls a C function that fills a struct, whose structSize `sized` has set, and returns the struct.
func filled<T>(_ empty: T, _ fill: (UnsafeMutablePointer<T>) -> DplResult) throws(DoppelError) -> T {
    var out = empty
    try check(fill(&out))
    return out
}

/// A struct of the C interface whose first field is its size.
protocol Sized {
    init()
    var structSize: UInt32 { get set }
}

extension Sized {
    static var sized: Self {
        var out = Self()
        out.structSize = UInt32(MemoryLayout<Self>.size)
        return out
    }
}

extension DplContextInfo: Sized {}
extension DplAvatarInfo: Sized {}
extension DplFileAxes: Sized {}
extension DplJointInfo: Sized {}
extension DplExpressionInfo: Sized {}
extension DplClipInfo: Sized {}
extension DplClipLayer: Sized {}
extension DplClipOptions: Sized {}
extension DplGaze: Sized {}
extension DplFaceMotion: Sized {}
extension DplPoseTrust: Sized {}
extension DplContactShadow: Sized {}
extension DplLayerInfo: Sized {}
extension DplPick: Sized {}
extension DplLoadInfo: Sized {}
extension DplLoadStatus: Sized {}
extension DplCamera: Sized {}
extension DplImage: Sized {}
extension DplDetail: Sized {}
extension DplFrameStats: Sized {}
extension DplBufferElement: Sized {}
extension DplBuffer: Sized {}
extension DplSplatOptions: Sized {}
extension DplWritten: Sized {}

/// A handle of the C interface. It is a number that the library checks, and the library orders calls of different threads.
struct Handle: @unchecked Sendable {
    let raw: OpaquePointer
}
