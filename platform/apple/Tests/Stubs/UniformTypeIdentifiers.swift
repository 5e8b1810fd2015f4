// SPDX-License-Identifier: Apache-2.0
// UniformTypeIdentifiers: what this package uses of it. Declarations only, checked against the public documentation; see README.md.

public struct UTType: Sendable {
    public static var data: UTType { fatalError() }
}
