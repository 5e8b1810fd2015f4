// SPDX-License-Identifier: Apache-2.0
// Reads arrays of numbers from NumPy archives (.npz, a zip of .npy files), with limits on size. Pickled objects are refused.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

/** One array, converted to double, in C order. */
struct NpyArray {
    std::vector<size_t> shape;
    std::vector<double> values;
};

/** The entries of an .npz by name (without ".npy"). read() unpacks one. The bytes given to open() must outlive the object. */
class NpzFile {
public:
    /** Checks the zip directory. CorruptData when it is damaged, Unsupported for zip64 and encryption. */
    static Result<NpzFile> open(std::span<const uint8_t> bytes);

    bool has(const std::string& name) const { return entries_.count(name) != 0; }

    /** Unpacks one array of floats or integers. Refused: object arrays (pickles), big-endian data, more than `maxBytes`. */
    Result<NpyArray> read(const std::string& name, size_t maxBytes) const;

private:
    struct Entry {
        std::span<const uint8_t> stored;
        size_t plainBytes = 0;
        bool deflated = false;
    };
    std::map<std::string, Entry> entries_;
};

/** Parses one .npy file. */
Result<NpyArray> parseNpy(std::span<const uint8_t> bytes);

}  // namespace dpl
