// SPDX-License-Identifier: Apache-2.0
// Buffers of one owner, destroyed together.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "sdk/backend/backend.h"

namespace dpl {

/** Creates buffers and destroys them with itself. The backend must live longer. Move-only. One thread at a time, as the backend. */
class DeviceBuffers {
public:
    explicit DeviceBuffers(Backend& backend) : backend_(&backend) {}
    DeviceBuffers(DeviceBuffers&& other) noexcept : backend_(other.backend_), ids_(std::move(other.ids_)) { other.ids_.clear(); }
    DeviceBuffers& operator=(DeviceBuffers&& other) noexcept {
        std::swap(backend_, other.backend_);
        std::swap(ids_, other.ids_);
        return *this;
    }
    ~DeviceBuffers() {
        for (const BufferId id : ids_) backend_->destroyBuffer(id);
    }

    /** At least 16 bytes, because no backend binds an empty buffer. */
    Result<BufferId> create(std::string label, uint64_t bytes, BufferMemory memory = BufferMemory::Device) {
        DPL_TRY(const BufferId id, backend_->createBuffer({std::move(label), std::max<uint64_t>(bytes, 16), memory}));
        ids_.push_back(id);
        return id;
    }

private:
    Backend* backend_;
    std::vector<BufferId> ids_;
};

}  // namespace dpl
