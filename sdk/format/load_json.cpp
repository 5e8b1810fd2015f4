// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/load_json.h"

#include <new>

namespace dpl {
namespace {

thread_local JsonReserve* newest = nullptr;

/** Vectors of JSON values that a load can need at once, as children of one value each: those of three trees (the file, its known keys, and
 *  tinygltf's), of a copy of a part, and of the destructor that runs. A vector that grows by doubling asks for at most four times what it
 *  holds, and a reserve takes back only all its blocks at once. */
constexpr size_t kVectorsPerValue = 5 * 4;

}  // namespace

JsonReserve::JsonReserve(size_t values)
    : size_((values + 64) * kVectorsPerValue * sizeof(nlohmann::json)), memory_(new std::byte[size_]), older_(newest) {
    newest = this;
}

JsonReserve::~JsonReserve() {
    newest = older_;
}

void* JsonReserve::take(size_t bytes) noexcept {
    if (!newest || bytes > newest->size_ - newest->used_) return nullptr;
    void* const memory = newest->memory_.get() + newest->used_;
    newest->used_ += bytes, ++newest->blocks_;
    return memory;
}

bool JsonReserve::giveBack(void* memory) noexcept {
    const auto* at = static_cast<std::byte*>(memory);
    for (JsonReserve* reserve = newest; reserve; reserve = reserve->older_) {
        const std::byte* begin = reserve->memory_.get();
        if (std::less<>()(at, begin) || !std::less<>()(at, begin + reserve->size_)) continue;
        if (--reserve->blocks_ == 0) reserve->used_ = 0;
        return true;
    }
    return false;
}

}  // namespace dpl

nlohmann::json* std::allocator<nlohmann::json>::allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(nlohmann::json);
    if (count > std::size_t(-1) / sizeof(nlohmann::json)) throw std::bad_array_new_length();
    void* memory = ::operator new(bytes, std::nothrow);
    if (!memory) memory = dpl::JsonReserve::take(bytes);
    if (!memory) throw std::bad_alloc();
    return static_cast<nlohmann::json*>(memory);
}

void std::allocator<nlohmann::json>::deallocate(nlohmann::json* values, std::size_t) noexcept {
    if (!dpl::JsonReserve::giveBack(values)) ::operator delete(values);
}
