// SPDX-License-Identifier: Apache-2.0
// Objects of a backend that were destroyed while commands of an app may need them.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace dpl {

/** Keeps objects, the oldest first, until every slot has come round. Frames are numbered as they are encoded. */
template <class Object>
class RetiredObjects {
public:
    /** Frees an object once no commands of the app can need it: at once if no frame was encoded since it was created. born, encoded: the
     *  numbers of the last frame when it was created, and now. */
    template <class Free>
    void retire(Object object, uint64_t born, uint64_t encoded, const Free& free) {
        if (born < encoded)
            kept_.push_back({encoded, std::move(object)});
        else
            free(object);
    }
    /** Frees what only frames before `oldest` can need. */
    template <class Free>
    void freeBefore(uint64_t oldest, const Free& free) {
        while (!kept_.empty() && kept_.front().encoded < oldest) {
            free(kept_.front().object);
            kept_.erase(kept_.begin());
        }
    }
    template <class Visit>
    void forEach(const Visit& visit) {
        for (Kept& kept : kept_) visit(kept.object);
    }
    template <class Visit>
    void forEach(const Visit& visit) const {
        for (const Kept& kept : kept_) visit(kept.object);
    }

private:
    struct Kept {
        uint64_t encoded = 0;  // number of the last frame that was encoded before
        Object object;
    };
    std::vector<Kept> kept_;
};

}  // namespace dpl
