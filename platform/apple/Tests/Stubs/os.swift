// SPDX-License-Identifier: Apache-2.0
// os: what this package uses of it. Declarations only, checked against the public documentation; see README.md.

public func os_proc_available_memory() -> Int { fatalError() }
