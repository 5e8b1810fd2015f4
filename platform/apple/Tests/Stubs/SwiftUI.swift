// SPDX-License-Identifier: Apache-2.0
// SwiftUI: what this package uses of it. Declarations only, checked against the public documentation; see README.md.
@_exported import Combine
@_exported import Foundation
import UniformTypeIdentifiers

#if canImport(UIKit)
    import UIKit
#elseif canImport(AppKit)
    import AppKit
#endif

// Views.

@MainActor @preconcurrency public protocol View {
    associatedtype Body: View
    @ViewBuilder var body: Body { get }
}

extension Never: View {
    public var body: Never { return fatalError() }
}

/// Stands for every view whose type nobody names.
public struct SomeView: View {
    nonisolated init() {}
    public var body: Never { return fatalError() }
}

@resultBuilder public enum ViewBuilder {
    public static func buildBlock() -> SomeView { SomeView() }
    public static func buildBlock<each Content: View>(_ content: repeat each Content) -> SomeView { SomeView() }
    public static func buildExpression<Content: View>(_ content: Content) -> Content { content }
    public static func buildIf(_ content: SomeView?) -> SomeView { SomeView() }
    public static func buildEither<Content: View>(first: Content) -> SomeView { SomeView() }
    public static func buildEither<Content: View>(second: Content) -> SomeView { SomeView() }
}

@MainActor public struct VStack: View {
    public init(@ViewBuilder content: () -> some View) {}
    public var body: Never { return fatalError() }
}

@MainActor public struct HStack: View {
    public init(@ViewBuilder content: () -> some View) {}
    public var body: Never { return fatalError() }
}

@MainActor public struct ZStack: View {
    public init(@ViewBuilder content: () -> some View) {}
    public var body: Never { return fatalError() }
}

@MainActor public struct Spacer: View {
    public init() {}
    public var body: Never { return fatalError() }
}

@MainActor public struct Text: View {
    public init(_ content: some StringProtocol) {}
    public var body: Never { return fatalError() }
}

@MainActor public struct Button: View {
    public init(_ title: some StringProtocol, action: @escaping @MainActor () -> Void) {}
    public var body: Never { return fatalError() }
}

@MainActor public struct ProgressView: View {
    public init(value: Double?, total: Double = 1) {}
    public var body: Never { return fatalError() }
}

@MainActor public struct Picker<Selection: Hashable>: View {
    public init(_ title: some StringProtocol, selection: Binding<Selection>, @ViewBuilder content: () -> some View) {}
    public var body: Never { return fatalError() }
}

public struct GeometryProxy {
    public var size: CGSize { fatalError() }
}

@MainActor public struct GeometryReader<Content: View>: View {
    public init(@ViewBuilder content: @escaping (GeometryProxy) -> Content) {}
    public var body: Never { return fatalError() }
}

public struct SegmentedPickerStyle: Sendable { public init() {} }
public protocol PickerStyle {}
extension SegmentedPickerStyle: PickerStyle {}
extension PickerStyle where Self == SegmentedPickerStyle {
    public static var segmented: SegmentedPickerStyle { SegmentedPickerStyle() }
}

extension View {
    public func padding() -> some View { SomeView() }
    public func tag(_ tag: some Hashable) -> some View { SomeView() }
    public func id(_ id: some Hashable) -> some View { SomeView() }
    public func disabled(_ disabled: Bool) -> some View { SomeView() }
    public func pickerStyle(_ style: some PickerStyle) -> some View { SomeView() }
    public func gesture(_ gesture: some Gesture) -> some View { SomeView() }
    public func fileImporter(
        isPresented: Binding<Bool>, allowedContentTypes: [UTType], onCompletion: @escaping (Result<URL, any Error>) -> Void
    ) -> some View { SomeView() }
}

// State.

@propertyWrapper public struct Binding<Value> {
    public init(get: @escaping () -> Value, set: @escaping (Value) -> Void) {}
    public var wrappedValue: Value { get { fatalError() } nonmutating set {} }
    public static func constant(_ value: Value) -> Binding<Value> { fatalError() }
}

@propertyWrapper public struct State<Value> {
    public init(wrappedValue: Value) {}
    public var wrappedValue: Value { get { fatalError() } nonmutating set {} }
    public var projectedValue: Binding<Value> { fatalError() }
}

extension State where Value: ExpressibleByNilLiteral {
    public init() { fatalError() }
}

@MainActor @propertyWrapper public struct StateObject<Object: ObservableObject> {
    public init(wrappedValue: @autoclosure @escaping () -> Object) {}
    public var wrappedValue: Object { fatalError() }
}

@MainActor @propertyWrapper public struct ObservedObject<Object: ObservableObject> {
    @dynamicMemberLookup public struct Wrapper {
        public subscript<Value>(dynamicMember path: ReferenceWritableKeyPath<Object, Value>) -> Binding<Value> { fatalError() }
    }
    public init(wrappedValue: Object) {}
    public var wrappedValue: Object { fatalError() }
    public var projectedValue: Wrapper { fatalError() }
}

public struct EnvironmentValues {
    public var openImmersiveSpace: OpenImmersiveSpaceAction { fatalError() }
    public var dismissImmersiveSpace: DismissImmersiveSpaceAction { fatalError() }
}

@propertyWrapper public struct Environment<Value> {
    public init(_ path: KeyPath<EnvironmentValues, Value>) {}
    public var wrappedValue: Value { fatalError() }
}

// Gestures.

@MainActor @preconcurrency public protocol Gesture<Value> {
    associatedtype Value
}

public struct ChangedGesture<Value>: Gesture {
    public func onChanged(_ action: @escaping (Value) -> Void) -> ChangedGesture<Value> { fatalError() }
    public func onEnded(_ action: @escaping (Value) -> Void) -> ChangedGesture<Value> { fatalError() }
}

public struct DragGesture: Gesture {
    public struct Value: Sendable {
        public var translation: CGSize { fatalError() }
    }
    public nonisolated init() {}
    public func onChanged(_ action: @escaping (Value) -> Void) -> ChangedGesture<Value> { fatalError() }
}

public struct MagnificationGesture: Gesture {
    public typealias Value = CGFloat
    public nonisolated init() {}
    public func onChanged(_ action: @escaping (CGFloat) -> Void) -> ChangedGesture<CGFloat> { fatalError() }
}

// Scenes.

@MainActor @preconcurrency public protocol Scene {
    associatedtype Body: Scene
    @SceneBuilder var body: Body { get }
}

extension Never: Scene {}

public struct SomeScene: Scene {
    nonisolated init() {}
    public var body: Never { return fatalError() }
}

@resultBuilder public enum SceneBuilder {
    public static func buildBlock<each Content: Scene>(_ content: repeat each Content) -> SomeScene { SomeScene() }
}

@MainActor @preconcurrency public protocol App {
    associatedtype Body: Scene
    @SceneBuilder var body: Body { get }
    init()
}

extension App {
    public static func main() { fatalError() }
}

@MainActor public struct WindowGroup: Scene {
    public init(@ViewBuilder content: () -> some View) {}
    public var body: Never { return fatalError() }
}

@MainActor @preconcurrency public protocol ImmersiveSpaceContent {}

@resultBuilder public enum ImmersiveSpaceContentBuilder {
    public static func buildBlock<Content: ImmersiveSpaceContent>(_ content: Content) -> Content { content }
}

@MainActor public struct ImmersiveSpace: Scene {
    public init(id: String, @ImmersiveSpaceContentBuilder content: () -> some ImmersiveSpaceContent) {}
    public var body: Never { return fatalError() }
}

public protocol ImmersionStyle {}
public struct MixedImmersionStyle: ImmersionStyle { public init() {} }
public struct FullImmersionStyle: ImmersionStyle { public init() {} }
extension ImmersionStyle where Self == MixedImmersionStyle { public static var mixed: MixedImmersionStyle { MixedImmersionStyle() } }
extension ImmersionStyle where Self == FullImmersionStyle { public static var full: FullImmersionStyle { FullImmersionStyle() } }

extension Scene {
    public func immersionStyle(selection: Binding<any ImmersionStyle>, in styles: any ImmersionStyle...) -> some Scene { SomeScene() }
}

@MainActor public struct OpenImmersiveSpaceAction {
    public enum Result: Sendable { case opened, userCancelled, error }
    @discardableResult public func callAsFunction(id: String) async -> Result { fatalError() }
}

@MainActor public struct DismissImmersiveSpaceAction {
    public func callAsFunction() async { fatalError() }
}

#if canImport(UIKit)
    @MainActor @preconcurrency public protocol UIViewRepresentable: View where Body == Never {
        associatedtype UIViewType: UIView
        typealias Context = UIViewRepresentableContext<Self>
        func makeUIView(context: Context) -> UIViewType
        func updateUIView(_ uiView: UIViewType, context: Context)
    }

    extension UIViewRepresentable {
        public var body: Never { return fatalError() }
    }

    @MainActor public struct UIViewRepresentableContext<Representable: UIViewRepresentable> {}
#elseif canImport(AppKit)
    @MainActor @preconcurrency public protocol NSViewRepresentable: View where Body == Never {
        associatedtype NSViewType: NSView
        typealias Context = NSViewRepresentableContext<Self>
        func makeNSView(context: Context) -> NSViewType
        func updateNSView(_ nsView: NSViewType, context: Context)
    }

    extension NSViewRepresentable {
        public var body: Never { return fatalError() }
    }

    @MainActor public struct NSViewRepresentableContext<Representable: NSViewRepresentable> {}
#endif

// Of Foundation, which Linux lacks.

extension URL {
    public func startAccessingSecurityScopedResource() -> Bool { fatalError() }
    public func stopAccessingSecurityScopedResource() {}
}
