// SPDX-License-Identifier: Apache-2.0
import CDoppel

/// What the face shows, beside the pose.
extension Avatar {
    /// One of the 52 expressions, by ARKit's name.
    public struct Expression: Sendable, Equatable {
        public let name: String
        /// This avatar holds it; otherwise its weight changes nothing.
        public let isDrawn: Bool
    }

    /// All of them, in ARKit's order.
    public func expressions() throws(DoppelError) -> [Expression] {
        var all: [Expression] = []
        for index in 0..<UInt32(DPL_EXPRESSION_COUNT) {
            let c = try filled(DplExpressionInfo.sized) { dplGetExpressionInfo(handle.raw, index, $0) }
            all.append(Expression(name: String(cString: c.name), isDrawn: c.drawn != 0))
        }
        return all
    }

    /// Index of an expression by its name; see `dplFindExpression`.
    public static func findExpression(_ name: String) throws(DoppelError) -> Int {
        Int(try filled(UInt32(0)) { dplFindExpression(name, $0) })
    }

    /// Sets the face, until it is changed; poses do not touch it. weights: 52 of 0 to 1, in the order of `expressions()`. See
    /// `dplSetExpression`.
    public func setExpression(_ weights: [Float]) throws(DoppelError) {
        try check(dplSetExpression(handle.raw, weights, try c(weights.count)))
    }

    /// The same by names of ARKit, MediaPipe, Live Link, VRM or OpenXR; all others become zero. See `dplSetExpressionNamed`.
    public func setExpression(_ weights: [String: Float]) throws(DoppelError) {
        try setExpression(names: Array(weights.keys), weights: Array(weights.values))
    }

    /// The same for a stream that gives names and weights apart.
    public func setExpression(names: [String], weights: [Float]) throws(DoppelError) {
        guard names.count == weights.count else {
            throw DoppelError(.invalidArgument, "\(names.count) names and \(weights.count) weights; a weight is needed for each name")
        }
        let count = try c(names.count)
        var text: [CChar] = []
        var starts: [Int] = []
        for name in names {
            starts.append(text.count)
            text.append(contentsOf: name.utf8CString)
        }
        let result = text.withUnsafeBufferPointer { characters in
            var given = starts.map { start in characters.baseAddress.map { $0 + start } }
            given.append(nil)  // an empty list has names too
            return dplSetExpressionNamed(handle.raw, given, weights, count)
        }
        try check(result)
    }

    /// The current expression: 52 weights of 0 to 1.
    public func expression() throws(DoppelError) -> [Float] {
        var weights = [Float](repeating: 0, count: Int(DPL_EXPRESSION_COUNT))
        try check(dplGetExpression(handle.raw, &weights, UInt32(weights.count)))
        return weights
    }
}
