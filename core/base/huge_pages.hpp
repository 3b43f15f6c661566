#pragma once

namespace musclebench {

/// Asks the system to hold what this process has allocated so far in pages of 2 MiB, where it can. Queries and
/// constraints that jump about in megabytes otherwise wait for the page table nearly as long as for the data. It is
/// asked once for the whole process, between building and the first frame, and not array by array: arrays of less than
/// 2 MiB and the ends of larger ones lie in one page with their neighbours, and every backend is treated alike. Best
/// effort: where it is not granted (another system, too little memory) nothing changes.
void move_to_huge_pages();

}  // namespace musclebench
