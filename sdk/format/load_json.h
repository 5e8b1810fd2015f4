// SPDX-License-Identifier: Apache-2.0
// nlohmann/json for files that may be read when memory is short. Include it instead of <nlohmann/json.hpp>. Internal.
//
// A value of nlohmann/json puts its children into a vector before it destroys them. If the heap refuses that vector, the exception leaves a
// destructor and the process ends. JsonReserve holds memory for such vectors. (sdk/format/README.md.)
#pragma once

#ifdef INCLUDE_NLOHMANN_JSON_HPP_
#error "load_json.h comes before nlohmann/json.hpp"
#endif
// A namespace of its own: other files of the process keep std::allocator for their values.
#define NLOHMANN_JSON_NAMESPACE nlohmann::doppel_load
#define NLOHMANN_JSON_NAMESPACE_BEGIN \
    namespace nlohmann {              \
    inline namespace doppel_load {
#define NLOHMANN_JSON_NAMESPACE_END \
    }                               \
    }

#include <cstddef>
#include <memory>
#include <type_traits>

#include <nlohmann/json_fwd.hpp>

/** Memory of vectors of JSON values: from the heap, and where it refuses from the thread's newest JsonReserve. */
template <>
class std::allocator<nlohmann::json> {
public:
    using value_type = nlohmann::json;
    using size_type = std::size_t;
    using difference_type = std::ptrdiff_t;
    using propagate_on_container_move_assignment = std::true_type;
    using is_always_equal = std::true_type;

    allocator() noexcept = default;
    template <class Other>
    allocator(const std::allocator<Other>&) noexcept {}
    [[nodiscard]] nlohmann::json* allocate(std::size_t count);
    void deallocate(nlohmann::json* values, std::size_t count) noexcept;
    friend bool operator==(const allocator&, const allocator&) noexcept { return true; }
};

#include <nlohmann/json.hpp>

namespace dpl {

/** Memory for the destructors of all JSON values that the thread makes and destroys while the reserve lives. Declare it before them. */
class JsonReserve {
public:
    /** values: of the file, keys included. Throws std::bad_alloc. */
    explicit JsonReserve(size_t values);
    ~JsonReserve();
    JsonReserve(const JsonReserve&) = delete;
    JsonReserve& operator=(const JsonReserve&) = delete;

    static void* take(size_t bytes) noexcept;     // of the thread's newest reserve; null: none, or it is used up
    static bool giveBack(void* memory) noexcept;  // false: the memory is of no reserve

private:
    size_t size_, used_ = 0, blocks_ = 0;
    std::unique_ptr<std::byte[]> memory_;
    JsonReserve* const older_;
};

}  // namespace dpl
