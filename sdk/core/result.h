// SPDX-License-Identifier: Apache-2.0
// Errors are values: Result<T> holds a T or an Error (a code and a sentence for a human).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace dpl {

enum class Code : uint8_t {
    InvalidArgument,  // the caller's mistake
    NotFound,         // a file or a name that is not there
    CorruptData,      // damaged bytes
    Version,          // a file version that this build does not read
    Unsupported,      // valid, but this build or machine cannot do it
    OutOfMemory,
    Io,         // the file system refused (disk full, permissions)
    Device,     // the graphics device failed or is lost
    Cancelled,  // the user asked to stop
    Internal,
};

struct Error {
    Code code = Code::Internal;
    std::string message;
};

/** A value in a text: a text itself, a character, a whole number, a floating number or a bool (1 or 0). Borrows texts. */
class TextValue {
public:
    TextValue(std::string_view text) : kind_(Kind::Text), text_(text) {}
    TextValue(char character) : kind_(Kind::Character), character_(character) {}
    template <class T>
    TextValue(const T& value) {
        if constexpr (std::is_convertible_v<const T&, std::string_view>)
            kind_ = Kind::Text, text_ = value;
        else if constexpr (std::is_floating_point_v<T>)
            kind_ = Kind::Floating, floating_ = double(value);
        else if constexpr (std::is_unsigned_v<T>)
            kind_ = Kind::Unsigned, unsigned_ = value;
        else
            kind_ = Kind::Signed, signed_ = value;  // also enums of C
    }
    void appendTo(std::string& out) const;

private:
    enum class Kind : uint8_t { Text, Character, Unsigned, Signed, Floating } kind_;
    union {
        std::string_view text_;
        char character_;
        uint64_t unsigned_;
        int64_t signed_;
        double floating_;
    };
};

/** Replaces each "{}" of `text` by the next value. Values without a "{}" are dropped, and a "{}" without a value stays. */
std::string formatValues(std::string_view text, std::span<const TextValue> values);

/** The same. Floating numbers have six digits, as by printf's %g, with a point in every locale. */
template <class... Args>
std::string formatText(std::string_view text, const Args&... args) {
    const std::array<TextValue, sizeof...(args)> values = {TextValue(args)...};
    return formatValues(text, values);
}

template <class... Args>
Error fail(Code code, std::string_view text, const Args&... args) {
    return Error{code, formatText(text, args...)};
}

/** The error for a caught std::bad_alloc. what: "read an avatar". Says less if there is no memory even for the text. */
inline Error outOfMemory(const char* what) noexcept {
    try {
        return {Code::OutOfMemory, std::string("no memory to ") + what};
    } catch (...) {
        return {Code::OutOfMemory, "out of memory"};  // so short that std::string keeps it without allocating
    }
}

/** A value or an error. Test it before `*r`, `r->` or error(): reading the one that is not there is undefined. */
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : value_(std::move(value)) {}
    Result(Error error) : error_(std::move(error)) {}

    explicit operator bool() const { return value_.has_value(); }
    T& operator*() { return *value_; }
    const T& operator*() const { return *value_; }
    T* operator->() { return &*value_; }
    const T* operator->() const { return &*value_; }
    const Error& error() const { return error_; }

private:
    std::optional<T> value_;
    Error error_;
};

template <>
class [[nodiscard]] Result<void> {
public:
    Result() = default;
    Result(Error error) : error_(std::move(error)) {}

    explicit operator bool() const { return !error_.has_value(); }
    const Error& error() const { return *error_; }

private:
    std::optional<Error> error_;
};

using Status = Result<void>;

}  // namespace dpl

#define DPL_CONCAT_(a, b) a##b
#define DPL_CONCAT(a, b) DPL_CONCAT_(a, b)

// DPL_TRY(auto x, expression): declares x as the value of the Result, or returns its error from the calling function.
#define DPL_TRY(declaration, ...)                                                           \
    auto DPL_CONCAT(dplResult_, __LINE__) = (__VA_ARGS__);                                  \
    if (!DPL_CONCAT(dplResult_, __LINE__)) return DPL_CONCAT(dplResult_, __LINE__).error(); \
    declaration = std::move(*DPL_CONCAT(dplResult_, __LINE__))

// DPL_RETURN_IF_ERROR(status): returns the error of a Status, if it has one, from the calling function.
#define DPL_RETURN_IF_ERROR(...) \
    if (auto dplStatus = (__VA_ARGS__); !dplStatus) return dplStatus.error()
