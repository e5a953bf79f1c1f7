// How much memory this process may still take.
// SPDX-License-Identifier: MPL-2.0
#pragma once

namespace isocast {

/// The least of what the system has, what the limits of the process's control groups are, and what
/// its data limit (`ulimit -d`) leaves. Infinity where nothing is said.
double available_memory_bytes();

/// What a field that is read may take of it unless told otherwise: half, since its pictures and the
/// system's cache of files need some too.
inline double default_field_bytes() {
    return available_memory_bytes() / 2;
}

} // namespace isocast
