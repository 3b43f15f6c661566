#pragma once

#include <cstddef>
#include <string_view>

namespace musclebench {

/// Bytes that this machine could still give to the process; the largest value when the system does not tell.
std::size_t available_memory_bytes();

/// Resident memory of the process now; 0 when the system does not tell.
std::size_t resident_memory_bytes();

/// Largest resident memory of the process so far; 0 when the system does not tell.
std::size_t peak_resident_memory_bytes();

/// Throws InputError (location: `key`) that says how much is needed and how much is there when `bytes` do not fit.
void require_memory(std::size_t bytes, std::string_view key, std::string_view cure);

}  // namespace musclebench
