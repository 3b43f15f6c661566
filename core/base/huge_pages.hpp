#pragma once

#include <cstddef>
#include <span>

namespace musclebench {

/// Asks the system to hold `memory`, which is written already, in pages of 2 MiB where it can. Queries that jump about
/// in megabytes otherwise wait for the page table nearly as long as for the data. A wish: where it is not granted
/// (another system, too little memory) nothing changes. Memory that is smaller than such a page is left as it is.
void prefer_huge_pages(std::span<const std::byte> memory);

}  // namespace musclebench
