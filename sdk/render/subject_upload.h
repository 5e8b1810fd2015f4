// SPDX-License-Identifier: Apache-2.0
// Uploads the records of a subject, at once or slice by slice in the background of frames.
//
//   records ──(any thread)──► a slot of the staging ring ──(queueCopy)──► Device buffers
#pragma once

#include <span>
#include <vector>

#include "sdk/backend/backend.h"
#include "sdk/draw/renderer.h"
#include "sdk/render/device_buffers.h"

namespace dpl {

/** Records on the CPU, which outlive the upload, and the buffer that they go to. */
struct UploadPiece {
    BufferId to;
    std::span<const std::byte> from;
};

/** One thread at a time, as the backend, which must live longer. */
class SubjectUpload {
public:
    SubjectUpload(Backend& backend, std::vector<UploadPiece> pieces);

    /** Makes the staging ring when it is first called. Then queues the slice that the last call gave out, which the caller has filled, and
     *  gives out the next one; an empty one if none can be filled now. Returns the share of the records that is on the device. Neither
     *  waits nor, after the first call, allocates on the device. */
    Result<double> next(UploadSlice& slice);
    /** Writes all records and waits, whatever was uploaded before. */
    Status finish();

private:
    struct Place {           // in the ring
        uint64_t copy = 0;   // number of its queued copy; 0: free
        uint64_t bytes = 0;  // of the slice
    };
    Status makeRing();
    Status queueGiven();

    Backend& backend_;
    std::vector<UploadPiece> pieces_;
    DeviceBuffers buffers_;
    BufferId staging_;
    uint64_t placeBytes_ = 0;
    std::vector<Place> places_;
    size_t piece_ = 0;     // of the next slice
    uint64_t offset_ = 0;  // in that piece
    size_t given_ = 0;     // index of the place that is being filled; places_.size(): none
    BufferId givenTo_;     // and where its slice goes
    uint64_t givenOffset_ = 0;
    uint64_t allBytes_ = 0, doneBytes_ = 0;
};

}  // namespace dpl
