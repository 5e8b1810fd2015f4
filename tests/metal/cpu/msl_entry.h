// SPDX-License-Identifier: Apache-2.0
// How an entry point of MSL that was compiled as C++ (to_cpp.cmake) is described and called. What its signature says is parsed from the
// MSL text; how large its arguments are comes from their C++ types.
#pragma once

#define GLM_FORCE_SWIZZLE
#define GLM_FORCE_SILENT_WARNINGS
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace msl {

constexpr uint32_t kSlots = 31;  // indices of buffers and of textures

/** Metal's default sample positions for four samples, from the pixel's top left corner. */
constexpr glm::vec2 kSamplePlaces[4] = {{0.375f, 0.125f}, {0.875f, 0.375f}, {0.125f, 0.625f}, {0.625f, 0.875f}};

enum class TextureShape : uint8_t { None = 0, Flat = 2, Array = 3, FlatSamples = 4, ArraySamples = 8 };  // as MTLTextureType

/** What shaders read of a texture. */
struct Texture {
    uint32_t widthPx = 0, heightPx = 0, layers = 1, samples = 1;
    virtual ~Texture() = default;
    virtual glm::vec4 texel(uint32_t x, uint32_t y, uint32_t layer, uint32_t sample) const = 0;
};

/** Memory of a buffer from the bound offset to its end. */
struct Range {
    std::byte* begin = nullptr;
    uint64_t bytes = 0;
};
struct Bindings {
    std::array<Range, kSlots> buffers{};
    std::array<const Texture*, kSlots> textures{};
};

struct Entry;

/** The shader that runs now. One at a time. */
struct Running {
    const Entry* entry = nullptr;
    const Bindings* bindings = nullptr;  // none: the sizes of buffers are not known, and nothing is checked
    bool discarded = false;              // by the fragment
    std::vector<std::string>* faults = nullptr;
    std::array<uint64_t, kSlots> low{}, high{};  // bytes of each buffer that elements of its array were used of; high 0: of none
};
inline Running running;

/** Records a fault of the running shader, once for each text. */
void shaderFault(const std::string& what);
void indexFault(const void* from, size_t at, size_t bytes);

/** Whether element `at` lies in the bound buffer that holds `from`. */
inline bool holds(const void* from, size_t at, size_t bytes) {
    if (!running.bindings) return true;
    const auto* begin = static_cast<const std::byte*>(from);
    for (size_t i = 0; i < kSlots; ++i) {
        const Range& range = running.bindings->buffers[i];
        if (!range.begin || begin < range.begin || begin >= range.begin + range.bytes ||
            at >= size_t(range.begin + range.bytes - begin) / bytes)
            continue;
        const uint64_t offset = uint64_t(begin - range.begin) + at * bytes;
        if (running.high[i] == 0 || offset < running.low[i]) running.low[i] = begin == range.begin ? offset : 0;
        if (offset + bytes > running.high[i]) running.high[i] = begin == range.begin ? offset + bytes : range.bytes;
        return true;
    }
    return false;
}

/** The array without a size at the end of a buffer's struct. */
template <class T>
struct Unsized {
    T first;
    const T& operator[](size_t at) const {
        if (!holds(this, at, sizeof(T))) {
            static T nothing;
            indexFault(this, at, sizeof(T));
            std::memset(static_cast<void*>(&nothing), 0, sizeof(T));
            return nothing;
        }
        return *reinterpret_cast<const T*>(reinterpret_cast<const char*>(this) + at * sizeof(T));
    }
    T& operator[](size_t at) { return const_cast<T&>(std::as_const(*this)[at]); }
};

template <TextureShape kShape>
struct TextureArgument {
    static constexpr TextureShape kTextureShape = kShape;
    const Texture* texture = nullptr;
    uint32_t get_width(uint32_t lod = 0) const { return texture->widthPx; }
    uint32_t get_height(uint32_t lod = 0) const { return texture->heightPx; }
    uint32_t get_array_size() const { return texture->layers; }

protected:
    glm::vec4 texel(glm::uvec2 at, uint32_t layer, uint32_t sample) const {
        if (at.x < texture->widthPx && at.y < texture->heightPx && layer < texture->layers && sample < texture->samples)
            return texture->texel(at.x, at.y, layer, sample);
        shaderFault("reads a texel outside its texture");
        return glm::vec4(0);  // as Metal does
    }
};

enum class Stage : uint8_t { Compute, Vertex, Fragment };
enum class Given : uint8_t {  // what a parameter gets
    Buffer,
    Texture,
    StageIn,
    LaneInGroup,
    PlaceInGroup,
    PlaceInGrid,
    Group,
    VertexId,
    InstanceId,
    BaseInstance,
    Layer,
    Sample,
    Position,
    Unknown,
};
struct Parameter {
    std::string name;
    Given given = Given::Unknown;
    uint32_t index = 0;   // of a buffer or texture
    bool writes = false;  // of a buffer: it is not const
    size_t bytes = 0;     // of a buffer: the least that must be bound
    TextureShape shape = TextureShape::None;
};
/** A member of main0_in or main0_out. */
struct Field {
    std::string attribute;  // "position", "user(locn0)", "color(0)", "depth", "render_target_array_index"
    bool flat = false;
    uint32_t floats = 1;  // of 4 bytes
    uint32_t offset = 0;  // bytes
};

/** Arguments of one call. */
struct Invocation {
    const Bindings* bindings = nullptr;
    uint32_t lane = 0;
    glm::uvec3 group{0}, inGroup{0}, inGrid{0};
    uint32_t vertexId = 0, instanceId = 0, baseInstance = 0, layer = 0, sample = 0;
    glm::vec4 position{0};
    const void* stageIn = nullptr;
};

struct Entry {
    std::string name;       // as in the pack
    std::string_view text;  // MSL
    Stage stage = Stage::Compute;
    glm::uvec3 threads{1};  // of a threadgroup
    bool hasBarriers = false;
    std::vector<Parameter> parameters;
    std::vector<Field> inputs, outputs;
    size_t inputBytes = 0, outputBytes = 0;
    void (*call)(const Entry& entry, const Invocation& how, void* out) = nullptr;

    const Field* output(std::string_view attribute) const;
    bool takes(Given given) const;
};

template <class T>
struct Take {  // main0_in
    static constexpr size_t kBytes = sizeof(T);
    static constexpr TextureShape kShape = TextureShape::None;
    static T from(const Invocation& how, const Parameter&) { return *static_cast<const T*>(how.stageIn); }
};
template <class T>
struct Take<T&> {
    static constexpr size_t kBytes = sizeof(T);
    static constexpr TextureShape kShape = TextureShape::None;
    static T& from(const Invocation& how, const Parameter& p) {
        return *reinterpret_cast<std::remove_const_t<T>*>(how.bindings->buffers[p.index].begin);
    }
};
template <class T>
struct Take<T*> {  // only spvViewMask, two words
    static constexpr size_t kBytes = 2 * sizeof(T);
    static constexpr TextureShape kShape = TextureShape::None;
    static T* from(const Invocation& how, const Parameter& p) {
        return reinterpret_cast<std::remove_const_t<T>*>(how.bindings->buffers[p.index].begin);
    }
};
template <class T>
requires requires {
    T::kTextureShape;
}
struct Take<T> {
    static constexpr size_t kBytes = 0;
    static constexpr TextureShape kShape = T::kTextureShape;
    static T from(const Invocation& how, const Parameter& p) {
        T argument;
        argument.texture = how.bindings->textures[p.index];
        return argument;
    }
};
template <>
struct Take<uint32_t> {
    static constexpr size_t kBytes = 0;
    static constexpr TextureShape kShape = TextureShape::None;
    static uint32_t from(const Invocation& how, const Parameter& p) {
        switch (p.given) {
            case Given::VertexId:
                return how.vertexId;
            case Given::InstanceId:
                return how.instanceId;
            case Given::BaseInstance:
                return how.baseInstance;
            case Given::Layer:
                return how.layer;
            case Given::Sample:
                return how.sample;
            default:
                return how.lane;
        }
    }
};
template <>
struct Take<glm::uvec3> {
    static constexpr size_t kBytes = 0;
    static constexpr TextureShape kShape = TextureShape::None;
    static glm::uvec3 from(const Invocation& how, const Parameter& p) {
        return p.given == Given::PlaceInGrid ? how.inGrid : p.given == Given::PlaceInGroup ? how.inGroup : how.group;
    }
};
template <>
struct Take<glm::vec4> {
    static constexpr size_t kBytes = 0;
    static constexpr TextureShape kShape = TextureShape::None;
    static glm::vec4 from(const Invocation& how, const Parameter&) { return how.position; }
};

template <auto kFunction>
struct Caller;
template <class Return, class... Types, Return (*kFunction)(Types...)>
struct Caller<kFunction> {
    static void call(const Entry& entry, const Invocation& how, void* out) { call(entry, how, out, std::index_sequence_for<Types...>()); }
    template <size_t... kAt>
    static void call(const Entry& entry, const Invocation& how, void* out, std::index_sequence<kAt...>) {
        if constexpr (std::is_void_v<Return>) {
            kFunction(Take<Types>::from(how, entry.parameters[kAt])...);
        } else {
            const Return result = kFunction(Take<Types>::from(how, entry.parameters[kAt])...);
            std::memcpy(out, &result, sizeof result);
        }
    }
    static std::vector<size_t> bytes() { return {Take<Types>::kBytes...}; }
    static std::vector<TextureShape> shapes() { return {Take<Types>::kShape...}; }
    static constexpr size_t outputBytes() {
        if constexpr (std::is_void_v<Return>)
            return 0;
        else
            return sizeof(Return);
    }
};

/** Reads the signature in `text`. Aborts if it holds what the executor does not know: then the test must learn it. */
Entry describe(std::string_view name, std::string_view text, const std::vector<size_t>& bytes, const std::vector<TextureShape>& shapes,
               size_t outputBytes);

template <auto kFunction>
Entry makeEntry(std::string_view name, std::string_view text) {
    using C = Caller<kFunction>;
    Entry entry = describe(name, text, C::bytes(), C::shapes(), C::outputBytes());
    entry.call = C::call;
    return entry;
}

/** Runs the `lanes` threads of one threadgroup to their end. order: 0 forward, 1 reverse, 2 shuffled with a fixed seed.
 *  Returns false when some lanes end while others wait at a barrier. Not reentrant; call from one CPU thread. */
bool runGroup(uint32_t lanes, int order, const std::function<void(uint32_t lane)>& body);
/** Switches to the next fiber. Only valid inside runGroup(). */
void barrier();

/** Runs all threadgroups of a compute kernel. Returns false as runGroup() does. */
bool dispatch(const Entry& entry, const Bindings& bindings, glm::uvec3 groups, int order);

/** The same with buffers in the order of the kernel's parameters and of unknown sizes. */
bool dispatchInOrder(const Entry& entry, void* const* buffers, uint32_t groups, int order);

/** The shaders of the libraries that tests/metal/CMakeLists.txt makes of MSL. */
std::vector<const Entry*> fewEntries();
std::vector<const Entry*> mostEntries();
std::vector<const Entry*> trainingEntries();

/** All shaders of this program, and the one with a text or name; nullptr: it was not compiled (tests/metal/CMakeLists.txt). */
const std::vector<const Entry*>& allEntries();
const Entry* entryOfText(std::string_view text);
const Entry* entryNamed(std::string_view name);

/** Adds to the first two members; GLM's swizzles cannot be assigned to. */
inline void addToXy(glm::vec4& to, glm::vec2 what) {
    to.x += what.x, to.y += what.y;
}

}  // namespace msl
