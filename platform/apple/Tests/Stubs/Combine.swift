// SPDX-License-Identifier: Apache-2.0
// Combine: what this package uses of it. Declarations only, checked against the public documentation; see README.md.

public protocol ObservableObject: AnyObject {}

@propertyWrapper public struct Published<Value> {
    public init(wrappedValue: Value) { self.wrappedValue = wrappedValue }
    public var wrappedValue: Value
}
