// SPDX-License-Identifier: Apache-2.0
// Typed access to the fields of an extension in a file that may be hostile.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/load_json.h"

namespace dpl {

/** Typed access to the fields of an object. The error names a field that is missing or of the wrong type. */
class ExtensionFields {
public:
    ExtensionFields(const nlohmann::json& object, std::string where) : object_(object), where_(std::move(where)) {}

    Result<uint64_t> number(const char* key, uint64_t limit) const {
        auto it = find(key);
        if (it == object_.end() || !it->is_number_unsigned() || it->get<uint64_t>() > limit)
            return fail(Code::CorruptData, "{}: '{}' is missing, negative or too large", where_, key);
        return it->get<uint64_t>();
    }
    Result<float> real(const char* key) const {
        auto it = find(key);
        if (it == object_.end() || !it->is_number()) return fail(Code::CorruptData, "{}: '{}' is not a number", where_, key);
        return it->get<float>();
    }
    Result<bool> flag(const char* key) const {
        auto it = find(key);
        if (it == object_.end() || !it->is_boolean()) return fail(Code::CorruptData, "{}: '{}' is not true or false", where_, key);
        return it->get<bool>();
    }
    Result<std::string> text(const char* key) const {
        auto it = find(key);
        if (it == object_.end() || !it->is_string()) return fail(Code::CorruptData, "{}: '{}' is not a text", where_, key);
        return it->get<std::string>();
    }
    Status mustBe(const char* key, const char* value) const {
        DPL_TRY(const std::string found, text(key));
        if (found != value) return fail(Code::Unsupported, "{}: '{}' is '{}', only '{}' is read", where_, key, found, value);
        return {};
    }
    Result<const nlohmann::json*> array(const char* key) const {
        auto it = find(key);
        if (it == object_.end() || !it->is_array()) return fail(Code::CorruptData, "{}: '{}' is not an array", where_, key);
        for (const nlohmann::json& element : *it)
            if (!element.is_object()) return fail(Code::CorruptData, "{}: an entry of '{}' is not an object", where_, key);
        return &*it;
    }
    /** An array of at most `most` whole numbers, each at most `limit`. */
    Result<std::vector<uint32_t>> numbers(const char* key, size_t most, uint32_t limit) const {
        auto it = find(key);
        if (it == object_.end() || !it->is_array() || it->size() > most)
            return fail(Code::CorruptData, "{}: '{}' is not an array of at most {} numbers", where_, key, most);
        std::vector<uint32_t> out;
        for (const nlohmann::json& element : *it) {
            if (!element.is_number_unsigned() || element.get<uint64_t>() > limit)
                return fail(Code::CorruptData, "{}: an entry of '{}' is no number up to {}", where_, key, limit);
            out.push_back(element.get<uint32_t>());
        }
        return out;
    }
    /** An array of 1 to `most` numbers. */
    Result<std::vector<float>> reals(const char* key, size_t most) const {
        auto it = find(key);
        if (it == object_.end() || !it->is_array() || it->empty() || it->size() > most)
            return fail(Code::CorruptData, "{}: '{}' is not an array of 1 to {} numbers", where_, key, most);
        std::vector<float> out;
        for (const nlohmann::json& element : *it) {
            if (!element.is_number()) return fail(Code::CorruptData, "{}: an entry of '{}' is not a number", where_, key);
            out.push_back(element.get<float>());
        }
        return out;
    }
    bool has(const char* key) const { return find(key) != object_.end(); }
    Result<const nlohmann::json*> object(const char* key) const {
        auto it = find(key);
        if (it == object_.end() || !it->is_object()) return fail(Code::CorruptData, "{}: '{}' is not an object", where_, key);
        return &*it;
    }

private:
    nlohmann::json::const_iterator find(const char* key) const { return object_.is_object() ? object_.find(key) : object_.end(); }
    const nlohmann::json& object_;
    std::string where_;
};

}  // namespace dpl
