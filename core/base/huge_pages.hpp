#pragma once

namespace musclebench {

/// Requests huge pages (2 MiB) for all memory that this process has allocated so far. Queries and constraints with
/// random access to megabytes otherwise spend nearly as long on TLB misses as on cache misses. Called once for the
/// whole process, between building and the first frame, and not array by array: arrays of less than 2 MiB and the ends
/// of larger ones share a page with their neighbours, and every backend is treated alike. Best effort: where it is not
/// granted (another system, too little memory) nothing changes.
void move_to_huge_pages();

}  // namespace musclebench
