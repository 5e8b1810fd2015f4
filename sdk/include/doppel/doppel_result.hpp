// SPDX-License-Identifier: Apache-2.0
// How calls of the C++ wrapper end: a value, or an error with a sentence. Part of doppel.hpp, which includes it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>

#include <doppel/doppel.h>

namespace doppel {

/** Why a call failed. */
struct Error {
    DplResult code = DPL_ERROR_INTERNAL;
    std::string message;  // a sentence for a human
};

/** `code` with the text of the last call that failed on this thread. */
inline Error lastError(DplResult code) {
    return {code, dplGetLastError()};
}

/** A value or an error. Test it before use: reading the value of an error, or the error of a value, is undefined. */
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

/** Success or an error. */
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

/** What functions without a value return. */
using Status = Result<void>;

/** The Status of a C call that has just returned `result` on this thread. */
inline Status status(DplResult result) {
    if (result == DPL_OK) return {};
    return lastError(result);
}

/** A struct of the C interface whose structSize is set, and all else 0. */
template <class T>
struct Sized : T {
    Sized() : T{} { this->structSize = sizeof(T); }
    /** Functions that take several take one. */
    operator std::span<const T>() const { return {static_cast<const T*>(this), 1}; }
};
using ContextInfo = Sized<DplContextInfo>; /**< for the functions that take a DplContextInfo */
using Image = Sized<DplImage>;             /**< for the functions that take a DplImage */
using ClipOptions = Sized<DplClipOptions>; /**< for the functions that take a DplClipOptions */
using Detail = Sized<DplDetail>;           /**< for the functions that take a DplDetail */

/** Calls get(arguments..., &out) with a struct of type T whose structSize is set, and returns the struct. */
template <class T, class Get, class... Arguments>
Result<T> filled(Get get, Arguments... arguments) {
    T out{};
    out.structSize = sizeof out;
    if (const DplResult r = get(arguments..., &out); r != DPL_OK) return lastError(r);
    return out;
}

}  // namespace doppel
