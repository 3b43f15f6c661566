#pragma once

#include <cstddef>

namespace musclebench {

/// Requests huge pages (2 MiB) for all memory that this process has allocated so far. Queries and constraints with
/// random access to megabytes otherwise spend nearly as long on TLB misses as on cache misses. Called once for the
/// whole process, between building and the first frame, and not array by array: arrays of less than 2 MiB and the ends
/// of larger ones share a page with their neighbours, and every backend is treated alike. Best effort: where it is not
/// granted (another system, too little memory) nothing changes.
void move_to_huge_pages();

/// The next `bytes` that the heap grows by come as huge pages where the system grants them, so that
/// `move_to_huge_pages` need not copy what is built there. They take addresses and no memory until they are used. Needs
/// a heap that keeps what is freed at its end (M_TRIM_THRESHOLD).
void reserve_huge_pages(std::size_t bytes);

}  // namespace musclebench
