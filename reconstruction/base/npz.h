// SPDX-License-Identifier: Apache-2.0
// Reads arrays of numbers from NumPy archives (.npz, a zip of .npy files), with limits on size. Pickled objects are refused.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "reconstruction/base/zip_file.h"
#include "sdk/core/result.h"

namespace dpl {

/** One array, converted to double, in C order. */
struct NpyArray {
    std::vector<size_t> shape;
    std::vector<double> values;
};

/** The arrays of an .npz by name (without ".npy"). read() unpacks one. The bytes given to open() must outlive the object. All arrays
 * together, and the unpacked bytes of the one that is read, take at most 64 times the archive's size and 64 MiB: a small archive cannot
 * unpack to gigabytes. */
class NpzFile {
public:
    /** Checks the zip directory. CorruptData when it is damaged, Unsupported for zip64 and encryption. */
    static Result<NpzFile> open(std::span<const uint8_t> bytes);

    /** Unpacks one array of floats or integers. Refused: object arrays (pickles), big-endian data, more than the limit above. */
    Result<NpyArray> read(const std::string& name);

private:
    ZipFile zip_;
    size_t budgetBytes_ = 0;
};

/** Parses one .npy file of at most `maxValues` numbers. */
Result<NpyArray> parseNpy(std::span<const uint8_t> bytes, size_t maxValues = SIZE_MAX);

}  // namespace dpl
